import math
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.log_pictures.decision_strips import decisions_of
from reflexarc_pictures.log_pictures.floor_plan import beam_ends, floor_plan_of
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
