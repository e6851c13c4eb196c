import math
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.log_pictures.decision_strips import decisions_of
from reflexarc_pictures.log_pictures.floor_plan import beam_ends, floor_plan_of
from reflexarc_runtime.sensing.mounting import Mount, pose_of
from support.round_room import ROOM_M, TICKS


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


def test_beams_begin_where_the_scanner_sits_and_end_where_it_looks():
    backwards = LaserScan(start_angle=-math.pi / 2, end_angle=math.pi / 2, ranges=[1.0, 2.0, 3.0])
    backwards.pose.CopyFrom(pose_of(Mount(0.5, 0.25, math.pi)))
    ends_m = beam_ends(backwards, 10.0, 20.0, 0.0)
    np.testing.assert_allclose(ends_m, [[10.5, 21.25], [8.5, 20.25], [10.5, 17.25]], atol=1e-9)
    ends_m = beam_ends(backwards, 10.0, 20.0, math.pi / 2)  # the same, a quarter to the left
    np.testing.assert_allclose(ends_m, [[8.75, 20.5], [9.75, 18.5], [12.75, 20.5]], atol=1e-9)


def test_a_scanner_upside_down_has_its_left_on_the_right():
    hanging = LaserScan(start_angle=-math.pi / 2, end_angle=0.0, ranges=[1.0, math.inf, 2.0])
    hanging.pose.CopyFrom(pose_of(Mount(upside_down=True)))
    ends_m = beam_ends(hanging, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(ends_m, [[2.0, 0.0], [0.0, 1.0]], atol=1e-9)


def test_ranges_and_angles_that_are_none_hit_nothing():
    ranges = [math.nan, 1e300, -1.0, 0.0, -math.inf, math.inf]
    assert not len(beam_ends(LaserScan(start_angle=-1, end_angle=1, ranges=ranges), 0, 0, 0))
    nowhere = LaserScan(start_angle=math.nan, end_angle=1.0, ranges=[1.0, 1.0])
    assert beam_ends(nowhere, 0.0, 0.0, 0.0).shape == (0, 2)
