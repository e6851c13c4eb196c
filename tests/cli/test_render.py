import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from matplotlib.image import imread

from reflexarc.main import main
from reflexarc.pictures.decisions import decisions_of
from reflexarc.pictures.floor_log import beam_ends, floor_plan_of
from reflexarc_logs.reader import read_log
from reflexarc_runtime.contract import PolicyContract, RetinaSpec
from reflexarc_runtime.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.policies import exported
from support.recordings import MS, PERIOD_NS, RUN, START_NS, drive

GOLDEN = Path(__file__).parents[1] / "golden"
TICKS = 40
ROOM_M = 4.0
"""Distance of the walls of a round room: every beam from its middle is as long."""


def message(topic: str, payload: LaserScan | PoseInFrame, slot: int) -> Message:
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
