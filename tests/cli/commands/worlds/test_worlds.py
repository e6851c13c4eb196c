import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from reflexarc.main import main
from reflexarc_sim_bridge.worlds.files import WORLDS, world_text
from reflexarc_sim_bridge.worlds.scenarios import Scenario


def said(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["worlds", *words]) == 0
    return capsys.readouterr().out


def test_every_named_world_is_listed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLUMNS", "120")
    text = said([], capsys)
    assert all(name in text for name in WORLDS)
    rows = json.loads(said(["--json"], capsys))["worlds"]
    assert [row["name"] for row in rows] == list(WORLDS)
    assert all(row["description"] and row["families"] for row in rows)


def test_the_worlds_that_are_shipped_cover_every_family(capsys: pytest.CaptureFixture[str]):
    rows = json.loads(said(["list", "--json"], capsys))["worlds"]
    assert {family for row in rows for family in row["families"]} == set(Scenario)
    families = {row["name"]: row["families"] for row in rows}
    assert families["reference-1"] == ["F2 rectangles"]
    assert families["mixed"] == ["F1 discs", "F2 rectangles"]
    assert families["dim"] == ["F2 rectangles", "F8 appearance"]
    assert families["late"] == ["F2 rectangles", "F10 timing"]


def test_what_is_shown_is_the_file_to_begin_with(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert said(["show", "crossing"], capsys) == world_text("crossing")
    mine = tmp_path / "mine.toml"
    mine.write_text(world_text("steps").replace('"steps"', '"mine"'))
    shown = json.loads(said(["show", str(mine), "--json"], capsys))
    assert shown["name"] == tomllib.loads(shown["toml"])["name"] == "mine"


def test_a_check_answers_with_its_exit_status_and_a_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    picture = tmp_path / "legacy.png"
    assert main(["worlds", "check", "legacy", "--seeds", "4", "-o", str(picture), "--json"]) == 1
    report = json.loads(capsys.readouterr().out)
    assert (report["name"], report["fair"], report["seeds"]) == ("legacy", False, 4)
    assert len(report["profile"]) == len(report["lateral_m"]) == 40
    height, width, _ = imread(picture).shape
    assert (height, width) == (520, 1200)
    assert len(np.unique(imread(picture).reshape(-1, 4), axis=0)) > 50
    assert main(["worlds", "check", "reference-1", "--seeds", "4"]) == 0
    text = capsys.readouterr().out
    assert "verdict" in text
    assert "2ρR says 36.00" in text


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["show"], "name or the file of a world"),
        (["check"], "name or the file of a world"),
        (["list", "discs"], "no world"),
        (["fly"], "fly"),
        (["show", "narnia"], "known: askew-30, askew-60, askew-90, automaton"),
        (["check", "none.toml"], "none.toml: cannot be read"),
        (["check", "bad.toml"], "bad.toml:3: layers[0].density_per_m2: expected a number, got 'x'"),
        (["check", "discs", "--seeds", "1"], "seeds: expected 2 to"),
        (["check", "discs", "-o", "a.jpg"], ".png"),
        (["show", "discs", "-o", "a.png"], "only check draws"),
    ],
)
def test_what_cannot_work_is_said_in_one_line(
    words: list[str],
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    Path("bad.toml").write_text('name = "b"\n[[layers]]\ndensity_per_m2 = "x"\nkind = "scatter"')
    try:
        status = main(["worlds", *words])
    except SystemExit as end:
        status = end.code
    complaint = capsys.readouterr().err
    assert status == 2
    assert expected in complaint
    assert len(complaint.strip().splitlines()) == 1
