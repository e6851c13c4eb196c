import math

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.importing.lidar_messages import ODOMETRY_FRAME, LidarMessages
from reflexarc_logs.importing.scan_line import Sweep, TimedPose

ANY_FLOATS = st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=300)
FINITE = st.just(0.0) | st.just(-0.0) | st.floats(allow_nan=False, allow_infinity=False)
TIMES_NS = st.none() | st.integers(-(10**18), 10**18)


def by_protobuf(ranges: list[float], time_ns: int | None) -> bytes:
    """The same scan, every field given to protobuf."""
    scan = LaserScan(frame_id="robot0", start_angle=-1.5, end_angle=1.5, ranges=ranges)
    scan.pose.orientation.w = 1.0
    scan.timestamp.seconds, scan.timestamp.nanos = divmod(time_ns or 0, 10**9)
    return scan.SerializeToString()


@given(ANY_FLOATS, TIMES_NS)
def test_a_scan_has_the_very_bytes_that_protobuf_makes(ranges: list[float], time_ns: int | None):
    sweep = Sweep(time_ns, -1.5, 1.5, np.array(ranges))
    assert LidarMessages("robot0").scan(sweep) == by_protobuf(ranges, time_ns)


def test_the_length_of_the_longest_scans_takes_more_than_two_bytes():
    ranges = [1.0 / k for k in range(1, 65_537)]
    sweep = Sweep(0, -1.5, 1.5, np.array(ranges))
    assert LidarMessages("robot0").scan(sweep) == by_protobuf(ranges, 0)


@given(FINITE, FINITE, FINITE, TIMES_NS)
def test_poses_and_transforms_have_the_very_bytes_that_protobuf_makes(
    x_m: float, y_m: float, heading_rad: float, time_ns: int | None
):
    place, messages = TimedPose(x_m, y_m, heading_rad, time_ns), LidarMessages("robot0")
    pose, transform = PoseInFrame(frame_id="odom"), FrameTransform()
    transform.parent_frame_id, transform.child_frame_id = "world", "robot0"
    for message, position, rotation in (
        (pose, pose.pose.position, pose.pose.orientation),
        (transform, transform.translation, transform.rotation),
    ):
        seconds, nanos = divmod(time_ns or 0, 10**9)
        message.timestamp.seconds, message.timestamp.nanos = seconds, nanos
        position.x, position.y = x_m, y_m
        rotation.z, rotation.w = math.sin(heading_rad / 2), math.cos(heading_rad / 2)
    assert messages.pose(place, ODOMETRY_FRAME) == pose.SerializeToString()
    assert messages.transform(place) == transform.SerializeToString()
