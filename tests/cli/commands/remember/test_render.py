import json
import math
import os
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from PIL import Image, ImageSequence

from reflexarc.main import main
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.policies import exported
from support.recordings import MS, PERIOD_NS
from support.round_room import TICKS, turning_log

GOLDEN = Path(__file__).parents[3] / "golden"


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    """A log of a robot that turns in a round room."""
    return turning_log(tmp_path / "turning.mcap")


def rendered(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["render", *words, "--json"]) == 0
    said: dict[str, object] = json.loads(capsys.readouterr().out)
    return said


def test_scans_and_poses_become_a_floor_plan(turning: Path, capsys: pytest.CaptureFixture[str]):
    picture = turning.with_suffix(".png")
    assert main(["render", str(turning), "-o", str(picture), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["kind"], said["bytes"]) == ("floor", picture.stat().st_size)
    height, width, _ = imread(picture).shape
    assert (height, width) == (720, 1400)
    assert len(np.unique(imread(picture).reshape(-1, 4), axis=0)) > 100


@pytest.mark.parametrize("name", ["nominal", "faults"])
def test_a_log_without_poses_becomes_a_picture_without_a_map(name: str, tmp_path: Path):
    picture = tmp_path / "picture.png"
    assert main(["render", str(GOLDEN / f"{name}.mcap"), "-o", str(picture)]) == 0
    assert imread(picture).shape[:2] == (460, 1200)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([str(GOLDEN / "nominal.mcap"), "--kind", "floor"], "no scan and no pose"),
        (["none.mcap"], "none.mcap"),
        ([str(GOLDEN / "README.md")], "expected an MCAP file"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_one_line(
    words: list[str], expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(["render", *words, "-o", str(tmp_path / "picture.png")]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_log_in_which_nothing_was_decided_says_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    from support.lidar import flaser

    text, log = tmp_path / "in.log", tmp_path / "scans.mcap"
    text.write_text(flaser())
    assert main(["import", "carmen", str(text), "-o", str(log)]) == 0
    capsys.readouterr()
    assert main(["render", str(log), "-o", str(tmp_path / "picture.png")]) == 2
    assert "found no ticks" in capsys.readouterr().err


def test_only_png_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["render", str(GOLDEN / "nominal.mcap"), "-o", str(tmp_path / "a.jpg")]) == 2
    assert ".png" in capsys.readouterr().err


def test_a_world_becomes_a_picture_and_a_film_of_what_happened(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    picture, film = tmp_path / "crossing.png", tmp_path / "crossing.gif"
    made = rendered(["crossing", "-o", str(picture), "--seconds", "4"], capsys)
    assert (made["kind"], made["bytes"], made["frames"]) == ("stretch", picture.stat().st_size, 1)
    assert len(np.unique(imread(picture).reshape(-1, 4), axis=0)) > 30
    made = rendered(["crossing", "-o", str(film), "--seconds", "1.5"], capsys)
    with Image.open(film) as image:
        assert (image.n_frames, made["frames"]) == (16, 16)
        assert image.info["duration"] == 100
        images = [np.array(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)]
    assert all((a != b).any() for a, b in pairwise(images))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["crossing.gif", "crossing.png"]


def test_a_policy_drives_where_one_is_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "policy.onnx").write_bytes(exported(reference_contract(), seed=1))
    words = ["plane", "--seconds", "2", "--policy", str(tmp_path / "policy.onnx")]
    pictures = [tmp_path / "blind.png", tmp_path / "driven.png"]
    rendered([*words[:3], "-o", str(pictures[0])], capsys)
    rendered([*words, "-o", str(pictures[1])], capsys)
    blind, driven = (imread(picture) for picture in pictures)
    assert blind.shape != driven.shape or (blind != driven).any()


def test_a_log_with_poses_becomes_a_film(turning: Path, capsys: pytest.CaptureFixture[str]):
    film = turning.with_suffix(".gif")
    made = rendered([str(turning), "-o", str(film)], capsys)
    frames = math.floor((TICKS - 1) * PERIOD_NS / (100 * MS)) + 1
    with Image.open(film) as image:
        assert (made["kind"], made["frames"], image.n_frames) == ("film", frames, frames)


def test_an_mp4_is_what_ffmpeg_made_of_the_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    fake = tmp_path / "bin" / "ffmpeg"
    fake.parent.mkdir()
    half_written = '#!/bin/sh\nfor last; do :; done\ncat > "${last#file:}"\n'
    fake.write_text(half_written)
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", f"{fake.parent}:{os.environ['PATH']}")
    film = tmp_path / "plane.mp4"
    made = rendered(["plane", "-o", str(film), "--seconds", "0.5"], capsys)
    assert (made["frames"], made["bytes"]) == (6, 6 * 600 * 540 * 3)
    fake.write_text(f"{half_written}echo Unknown encoder >&2\nexit 1\n")
    assert main(["render", "plane", "-o", str(film), "--seconds", "0.5"]) == 2
    assert "Unknown encoder" in capsys.readouterr().err
    assert film.stat().st_size == made["bytes"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bin", "plane.mp4"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["nowhere", "-o", "a.png"], "no world is named 'nowhere'"),
        (["plane", "-o", "none/a.png"], "no such folder"),
        (["plane", "-o", "."], ".png, .gif or .mp4"),
        (["plane", "-o", "a.mp4"], "needs ffmpeg"),
        (["plane", "-o", "a.gif", "--seconds", "nan"], "0.5 to 120"),
        (["plane", "-o", "a.gif", "--seed", "-1"], "0 to 2^64"),
        (["plane", "-o", "a.gif", "--kind", "floor"], "only for pictures of logs"),
        (["plane", "-o", "a.gif", "--from", "nan"], "0 to 36000"),
        (["plane", "-o", "a.gif", "--lane", "-1"], "0 to 2^64"),
        (["plane", "-o", "a.gif", "--setting", "field"], "only for cells of a suite"),
        (["plane", "-o", "a.gif", "--suite", "a.toml"], "only for results"),
        (["lite:none/0.10", "-o", "a.gif"], "expected one of discs/0.10"),
        (["none:discs/0.10", "-o", "a.gif"], "suite: expected one of"),
        (["lite:discs/0.10", "-o", "a.gif", "--rate", "0"], "0.1 to 10000"),
        (["results.json", "-o", "a.gif"], ".html or .png"),
        (["results.json", "-o", "a.html"], "results.json: cannot be read"),
        (["results.json", "-o", "a.html", "--seed", "1"], "only for worlds"),
        (["plane", "-o", "a.gif", "--policy", "none.onnx"], "none.onnx: cannot be read"),
        ([str(GOLDEN / "nominal.mcap"), "-o", "a.gif"], "needs poses, found none"),
        ([str(GOLDEN / "nominal.mcap"), "-o", "a.gif", "--seed", "1"], "only for worlds"),
        ([str(GOLDEN / "nominal.mcap"), "-o", "a.png", "--seconds", "2"], "shows all of it"),
    ],
)
def test_what_cannot_be_filmed_is_refused_in_one_line(
    words: list[str],
    expected: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    assert main(["render", *words]) == 2
    said = capsys.readouterr().err
    assert expected in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
