"""Logs whose poses are no places: what is left is drawn, and nothing breaks."""

import math
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.log_pictures.log_picture import draw_log
from reflexarc_pictures.log_pictures.logged_poses import poses_of
from reflexarc_pictures.rendering import render_log
from reflexarc_runtime.errors import LogError
from support.rewriting import Edit, rewrite
from support.round_room import TICKS

NO_PLACES = [math.nan, math.inf, -math.inf, 1e300, -2e6]


def displaced(value: float, every: int = 1) -> Edit:
    """An edit that puts every n-th pose at a place that is none."""

    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        if not topic.endswith("/pose") or nth % every:
            return payload
        pose = PoseInFrame.FromString(payload)
        pose.pose.position.y = value
        return pose.SerializeToString()

    return edit


@pytest.mark.parametrize("value", NO_PLACES)
def test_poses_that_are_no_places_are_left_out(turning: Path, tmp_path: Path, value: float):
    known = poses_of(read_log(rewrite(turning, tmp_path / "some.mcap", displaced(value, every=2))))
    assert known.places.shape == (TICKS // 2, 3)
    assert known.sent_ns.shape == known.logged_ns.shape == (TICKS // 2,)
    np.testing.assert_allclose(known.places[:, :2], [[3.0, -2.0]] * (TICKS // 2))


def test_a_heading_that_is_none_is_no_pose(turning: Path, tmp_path: Path):
    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        pose = PoseInFrame()
        pose.pose.orientation.z = math.nan
        return pose.SerializeToString() if topic.endswith("/pose") else payload

    assert not len(poses_of(read_log(rewrite(turning, tmp_path / "none.mcap", edit))).places)


@pytest.mark.parametrize("every", [1, 2])
def test_a_log_with_such_poses_is_drawn(turning: Path, tmp_path: Path, every: int):
    log = rewrite(turning, tmp_path / "log.mcap", displaced(math.nan, every))
    assert draw_log(log, tmp_path / "log.png") == ("drive" if every == 1 else "floor")
    assert draw_log(log, tmp_path / "drive.png", "drive") == "drive"


def test_a_film_of_no_places_is_refused_in_a_line(turning: Path, tmp_path: Path):
    log = rewrite(turning, tmp_path / "log.mcap", displaced(math.nan))
    with pytest.raises(LogError, match="a film needs poses, found none"):
        render_log(log, tmp_path / "log.gif")
