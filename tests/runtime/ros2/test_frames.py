import contextlib
import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.frames import (
    MAX_TF_BYTES,
    decode_odometry,
    decode_transforms,
)
from support.ros2 import Quaternion, TFMessage, Time, odometry, transform

LEFT = Quaternion(0.0, 0.0, math.sin(0.4), math.cos(0.4))
"""0.8 rad counter-clockwise."""
PLACE = odometry(1.5, -2.5, turn=LEFT, stamp=Time(7, 8)).serialize()
TWO = TFMessage([transform("laser", 0.25), transform("/wheel", turn=LEFT)]).serialize()


def test_odometry_becomes_a_pose_in_its_own_frame():
    pose = decode_odometry(PLACE)
    assert (pose.timestamp.seconds, pose.timestamp.nanos) == (7, 8)
    assert pose.frame_id == "odom"
    assert (pose.pose.position.x, pose.pose.position.y, pose.pose.position.z) == (1.5, -2.5, 0.0)
    heading_rad = 2.0 * math.atan2(pose.pose.orientation.z, pose.pose.orientation.w)
    assert heading_rad == pytest.approx(0.8)


def test_each_transform_of_a_message_is_one_of_ours():
    laser, wheel = decode_transforms(TWO)
    assert (laser.parent_frame_id, laser.child_frame_id) == ("base_link", "laser")
    assert (laser.timestamp.seconds, laser.timestamp.nanos) == (5, 6)
    assert (laser.translation.x, laser.rotation.w) == (0.25, 1.0)
    assert wheel.child_frame_id == "wheel"  # ROS 1 began frames with a slash
    assert wheel.rotation.z == math.sin(0.4)


def test_a_message_without_a_transform_is_fine():
    assert decode_transforms(TFMessage([]).serialize()) == []


UNUSABLE_PLACES: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "little-endian"),
    "cut off": (PLACE[:-8], "no nav_msgs/msg/Odometry"),
    "transforms": (TWO, "no nav_msgs/msg/Odometry"),
    "at NaN": (odometry(math.nan).serialize(), "a place that is none"),
    "at infinity": (odometry(y_m=math.inf).serialize(), "a place that is none"),
    "no rotation": (odometry(turn=Quaternion(w=0.0)).serialize(), "a rotation that is none"),
    "twice a rotation": (odometry(turn=Quaternion(w=2.0)).serialize(), "a rotation that is none"),
    "NaN turned": (odometry(turn=Quaternion(z=math.nan)).serialize(), "a rotation that is none"),
    "no frame": (odometry(frame="").serialize(), "a frame without a name"),
    "a long frame": (odometry(frame="a" * 257).serialize(), "a frame without a name"),
    "a name of noise": (PLACE.replace(b"odom", b"\xff\xfe\xfdm"), "no nav_msgs/msg/Odometry"),
}


@pytest.mark.parametrize("name", list(UNUSABLE_PLACES))
def test_what_is_no_place_is_refused_with_its_reason(name: str):
    payload, reason = UNUSABLE_PLACES[name]
    with pytest.raises(UnusableMessageError, match=reason):
        decode_odometry(payload)


UNUSABLE_TRANSFORMS: dict[str, tuple[bytes, str]] = {
    "one of two": (
        TFMessage([transform("a"), transform("b", math.nan)]).serialize(),
        "a place that is none",
    ),
    "four billion": (TWO[:4] + struct.pack("<I", 2**32 - 1) + TWO[8:], "no tf2_msgs"),
    "one more": (TWO[:4] + struct.pack("<I", 3) + TWO[8:], "no tf2_msgs"),
    "too long": (TFMessage([transform("a")] * 900).serialize(), "more than 64 KiB"),
}


@pytest.mark.parametrize("name", list(UNUSABLE_TRANSFORMS))
def test_what_is_no_transform_is_refused_with_its_reason(name: str):
    payload, reason = UNUSABLE_TRANSFORMS[name]
    with pytest.raises(UnusableMessageError, match=reason):
        decode_transforms(payload)


@given(st.binary(max_size=300))
def test_noise_is_read_or_refused(noise: bytes):
    for decode in (decode_odometry, decode_transforms):
        with contextlib.suppress(UnusableMessageError):
            decode(b"\x00\x01\x00\x00" + noise)


@given(st.integers(0, len(TWO) - 1), st.binary(min_size=1, max_size=8))
def test_damaged_transforms_are_read_or_refused(place: int, damage: bytes):
    with contextlib.suppress(UnusableMessageError):
        decode_transforms(TWO[:place] + damage + TWO[place + len(damage) :])


def test_the_messages_of_these_tests_have_the_layout_of_the_definition():
    # By hand: envelope, stamp, "odom" (4 + 5), padding, "base_link" (4 + 10), padding to 8, seven
    # doubles, 36, six, 36.
    assert len(PLACE) == 4 + 8 + (4 + 5) + 3 + (4 + 10) + 6 + 8 * (7 + 36 + 6 + 36)
    assert len(TFMessage([transform("a")] * 700).serialize()) <= MAX_TF_BYTES
