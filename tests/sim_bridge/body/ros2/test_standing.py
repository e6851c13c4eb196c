import math

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from reflexarc_sim_bridge.body.ros2.standing import Standing, says_standing
from support.ros2 import laser_scan, moving_odometry
from support.sensing import MS

STILL, MOVES = moving_odometry(), moving_odometry(0.5)


@pytest.mark.parametrize(
    ("payload", "stands"),
    [
        (moving_odometry(), True),
        (moving_odometry(frame="odd"), True),
        (moving_odometry(0.009), True),
        (moving_odometry(0.0, -0.011), False),
        (moving_odometry(0.008, 0.008), False),
        (moving_odometry(0.0, 0.0, 0.009), True),
        (moving_odometry(0.0, 0.0, -0.011), False),
        (moving_odometry(math.nan), False),
        (moving_odometry(0.0, 0.0, math.inf), False),
        (moving_odometry()[:-8][:100], False),
        (b"", False),
        (b"\x00\x00" + moving_odometry()[2:], False),
        (laser_scan([1.0] * 10).serialize(), False),
    ],
)
def test_a_message_says_that_the_base_stands_if_its_speeds_are_small(payload: bytes, stands: bool):
    assert says_standing(payload) is stands


@pytest.mark.parametrize(("speed_mps", "stands"), [(0.0, True), (0.2, False)])
def test_what_another_library_writes_is_read(speed_mps: float, stands: bool):
    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = store.types
    vector, zeros = kinds["geometry_msgs/msg/Vector3"], np.full(36, 0.25)
    time = kinds["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
    message = kinds["nav_msgs/msg/Odometry"](
        header=kinds["std_msgs/msg/Header"](stamp=time, frame_id="odom"),
        child_frame_id="base",
        pose=kinds["geometry_msgs/msg/PoseWithCovariance"](
            pose=kinds["geometry_msgs/msg/Pose"](
                position=kinds["geometry_msgs/msg/Point"](x=1.0, y=2.0, z=3.0),
                orientation=kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
            ),
            covariance=zeros,
        ),
        twist=kinds["geometry_msgs/msg/TwistWithCovariance"](
            twist=kinds["geometry_msgs/msg/Twist"](
                linear=vector(x=0.0, y=speed_mps, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0)
            ),
            covariance=zeros,
        ),
    )
    payload = bytes(store.serialize_cdr(message, "nav_msgs/msg/Odometry", little_endian=True))
    assert says_standing(payload) is stands


def after(*said: tuple[int, bytes]) -> Standing:
    known = Standing()
    for time_ms, payload in said:
        known = known.heard(payload, time_ms * MS)
    return known


def test_it_is_sure_after_a_fifth_of_a_second_without_a_gap():
    every = [(time_ms, STILL) for time_ms in range(0, 201, 50)]
    assert not after(*every[:-1]).is_sure(199 * MS)
    assert after(*every).is_sure(200 * MS)
    assert not after(*every).is_sure(400 * MS)  # it has fallen silent
    assert not after((0, STILL), (200, STILL)).is_sure(200 * MS)  # what was in between?
    assert not after(*every, (250, MOVES)).is_sure(250 * MS)
    assert not after((0, STILL), (50, MOVES), *every[2:], (240, STILL)).is_sure(240 * MS)


def test_who_was_never_heard_is_not_sure():
    assert not Standing().is_sure(10**12)
