import json
import math
import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from matplotlib.image import imread
from PIL import Image, ImageSequence

from reflexarc.main import main
from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.courses.course import Area
from reflexarc_pictures.courses.log_course import course_of
from reflexarc_pictures.courses.world_course import drive_in_world
from reflexarc_pictures.courses.world_scenery import WorldScenery
from reflexarc_pictures.log_pictures.decision_strips import decisions_of
from reflexarc_pictures.log_pictures.floor_plan import beam_ends, floor_plan_of
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract import PolicyContract, RetinaSpec
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.policies import exported
from support.recordings import CONTRACT, MS, PERIOD_NS, RUN, START_NS, drive, nominal

GOLDEN = Path(__file__).parents[3] / "golden"
TICKS = 40
ROOM_M = 4.0
"""Distance of the walls of a round room: every beam from its middle is as long."""


class ConstantPolicy:
    """Always does the same."""

    def __init__(self, action: int) -> None:
        self._action = action

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        n = len(retinas)
        return np.zeros((n, 3), np.float32), np.full(n, self._action)


def message(topic: str, payload: LaserScan | PoseInFrame | SceneUpdate, slot: int) -> Message:
    received_ns = START_NS + slot * PERIOD_NS - 3 * MS
    return Message(
        f"robot0/{topic}",
        payload.SerializeToString(),
        protobuf_encoding(payload.DESCRIPTOR.full_name),
        pack_stamp(Stamp(slot, received_ns - MS)),
        received_ns,
    )


def scan(length_m: float) -> LaserScan:
    beams = [length_m] * 179 + [math.inf, math.nan]
    return LaserScan(start_angle=-math.pi / 2, end_angle=math.pi / 2, ranges=beams)


def pose(x_m: float, y_m: float, heading_rad: float) -> PoseInFrame:
    pose = PoseInFrame(frame_id="world")
    pose.pose.position.x, pose.pose.position.y = x_m, y_m
    pose.pose.orientation.z = math.sin(heading_rad / 2)
    pose.pose.orientation.w = math.cos(heading_rad / 2)
    return pose


@pytest.fixture
def turning(tmp_path: Path) -> Path:
    """A log of a robot that turns once around in the middle, at (3, −2), of a round room."""
    contract = PolicyContract(retina=RetinaSpec(rays=8, fov_rad=3.0))
    slots = range(1, TICKS + 1)
    poses = [message("pose", pose(3.0, -2.0, 2 * math.pi * slot / TICKS), slot) for slot in slots]
    path = tmp_path / "turning.mcap"
    drive(
        path,
        exported(contract),
        {slot: [message("scan", scan(ROOM_M), slot)] for slot in slots},
        TICKS,
        run=replace(RUN, input="scan"),
        before=poses,
    )
    return path


def test_scans_and_poses_become_a_floor_plan(turning: Path, capsys: pytest.CaptureFixture[str]):
    picture = turning.with_suffix(".png")
    assert main(["render", str(turning), "-o", str(picture), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["kind"], said["bytes"]) == ("floor", picture.stat().st_size)
    height, width, _ = imread(picture).shape
    assert (height, width) == (720, 1400)
    assert len(np.unique(imread(picture).reshape(-1, 4), axis=0)) > 100


def test_the_plan_of_a_round_room_is_a_circle_around_the_robot(turning: Path):
    log = read_log(turning)
    plan = floor_plan_of(log, decisions_of(log))
    from_middle_m = np.hypot(*(plan.ends_m - [3.0, -2.0]).T)
    np.testing.assert_allclose(from_middle_m, ROOM_M, rtol=1e-12)
    assert len(plan.ends_m) == TICKS * 179
    np.testing.assert_allclose(plan.path_m, [[3.0, -2.0]] * (TICKS + 1))


def test_beams_end_where_heading_and_bearing_point():
    ahead_left = LaserScan(start_angle=0.0, end_angle=math.pi / 2, ranges=[1.0, math.inf, 2.0])
    ends_m = beam_ends(ahead_left, 10.0, 20.0, math.pi / 2)
    np.testing.assert_allclose(ends_m, [[10.0, 21.0], [8.0, 20.0]])


def test_what_was_decided_is_drawn_as_it_stands_in_the_log(turning: Path):
    log = read_log(turning)
    decisions, ticks = decisions_of(log), [tick.decision for tick in log.ticks()]
    assert decisions.actions.tolist() == [tick.action for tick in ticks]
    assert decisions.time_s[-1] == pytest.approx((ticks[-1].now_ns - ticks[0].now_ns) / 1e9)
    for row, values, tick in zip(decisions.retinas, decisions.q_values, ticks, strict=True):
        if tick.retina:
            assert bytes(row.astype(np.uint8)) == tick.retina
            assert values.tolist() == list(tick.q_values)
        else:
            assert np.isnan([*row, *values]).all()


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


def rendered(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["render", *words, "--json"]) == 0
    said: dict[str, object] = json.loads(capsys.readouterr().out)
    return said


def corners_around(simulation: Simulation, within_m: float) -> list[npt.NDArray[np.float64]]:
    """Of every obstacle that the eye has near, the box around it, if its middle is so close."""
    here = np.array([simulation.x_m[0], simulation.y_m[0]])
    boxes = []
    for outline in simulation.outlines_near(0):
        middle = np.array([outline.x_m, outline.y_m])
        reach_m = np.array([outline.radius_m, outline.radius_m])
        low, high = middle - reach_m, middle + reach_m
        if not outline.is_disc:
            low, high = outline.corners_m.min(axis=0), outline.corners_m.max(axis=0)
        if low[0] > here[0] and np.hypot(*(middle - here)) < within_m:
            boxes.append(np.concatenate([low, high]))
    return sorted(boxes, key=tuple)


@pytest.mark.parametrize("name", ["crossing", "swing", "stars", "corridor-10", "legacy"])
def test_what_is_drawn_is_what_the_eye_meets(name: str):
    simulation = Simulation(WORLDS[name].drawn(3), reference_contract(), np.array([3], np.uint64))
    for _ in range(25):
        simulation.step(np.zeros(1, np.int64))
    simulation.sense()
    x_m, y_m, time_s = float(simulation.x_m[0]), float(simulation.y_m[0]), 2.5
    seen = corners_around(simulation, 4.0)
    drawn = WorldScenery(simulation).within(Area(x_m, x_m + 8, y_m - 8, y_m + 8), time_s)
    boxes = [np.concatenate([s.corners_m.min(axis=0), s.corners_m.max(axis=0)]) for s in drawn]
    assert len(seen) > 1
    for box in seen:
        assert min(np.abs(np.array(boxes) - box).max(axis=1)) < 5e-3


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


def test_where_the_world_begins_anew_the_way_goes_on():
    source = WORLDS["reference-1"]
    to_the_left = ConstantPolicy(1)
    course = drive_in_world(source, reference_contract(), to_the_left, 0, 30.0)
    assert len(course.snapshots) == 301
    way_m = np.array([(snapshot.x_m, snapshot.y_m) for snapshot in course.snapshots])
    steps_m = np.hypot(*np.diff(way_m, axis=0).T)
    put = np.array([snapshot.put for snapshot in course.snapshots[1:]])
    np.testing.assert_allclose(steps_m[~put], math.hypot(0.1, 0.1), rtol=1e-6)
    assert way_m[:, 1].max() > 20.0
    assert put.sum() == len(course.contacts) > 0


def test_a_log_with_poses_becomes_a_film(turning: Path, capsys: pytest.CaptureFixture[str]):
    film = turning.with_suffix(".gif")
    made = rendered([str(turning), "-o", str(film)], capsys)
    frames = math.floor((TICKS - 1) * PERIOD_NS / (100 * MS)) + 1
    with Image.open(film) as image:
        assert (made["kind"], made["frames"], image.n_frames) == ("film", frames, frames)


def test_rays_out_of_a_log_are_as_long_as_its_retinas_say(turning: Path):
    course = course_of(read_log(turning), 10.0)
    rays_m = [snapshot.rays_m for snapshot in course.snapshots if snapshot.rays_m is not None]
    assert len(rays_m) > 3
    np.testing.assert_allclose(rays_m[-1], ROOM_M, atol=5.0 / 255)
    assert course.snapshots[0].retina is None
    assert (course.snapshots[1].x_m, course.snapshots[1].y_m) == (3.0, -2.0)


def test_a_film_of_a_log_shows_the_obstacles_that_the_body_told_of_last(tmp_path: Path):
    simulation = Simulation(WORLDS["crossing"].drawn(0), CONTRACT, np.array([0], np.uint64))
    told = [simulation.outlines_near(0)]
    for _ in range(20):
        simulation.step(np.zeros(1, np.int64))
    told.append(simulation.outlines_near(0))
    scenes = [SceneUpdate.FromString(encode_scene(outlines, 0)) for outlines in told]
    before = [message("pose", pose(0.1, 0.0, 0.0), slot) for slot in (1, 11)]
    before += [message("scene", scene, slot) for scene, slot in zip(scenes, (1, 11), strict=True)]
    path = tmp_path / "told.mcap"
    drive(path, exported(CONTRACT), nominal(20), 20, before=before)
    course, everywhere = course_of(read_log(path), 10.0), Area(-99.0, 99.0, -99.0, 99.0)
    for time_s, outlines in ((0.0, told[0]), (0.1, told[0]), (0.2, told[1])):
        shown = course.scenery.within(everywhere, time_s)
        middles = {tuple(np.round(s.corners_m.mean(axis=0), 6)) for s in shown}
        assert middles == {tuple(np.round([o.x_m, o.y_m], 6)) for o in outlines}


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
