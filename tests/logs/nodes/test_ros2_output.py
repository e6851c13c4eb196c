"""Messages of ROS 2 by any library, against pycdr2, which reads the bytes by itself."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from reflexarc_logs.nodes.message_codec import codec_of, stream_for
from reflexarc_logs.nodes.ros2_output import ros2_type_of
from support.ros2 import LaserScan, Twist

STORE = get_typestore(Stores.ROS2_JAZZY)
TWIST = stream_for("/cmd_vel", STORE.types["geometry_msgs/msg/Twist"](linear=None, angular=None))
SCAN = TWIST._replace(
    type_name="sensor_msgs/msg/LaserScan",
    schema=STORE.generate_msgdef("sensor_msgs/msg/LaserScan", ros_version=2)[0].encode(),
)


class OfRclpy:
    """As rclpy's classes are: fields are properties, and they name themselves."""

    _fields: ClassVar[dict[str, str]] = {"linear": "geometry_msgs/Vector3"}

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return cls._fields

    linear: ClassVar[dict[str, float]] = {"x": 0.5}


@dataclass
class OfAnybody:
    linear: dict[str, float]


@pytest.mark.parametrize(
    "said",
    [
        {"linear": {"x": 0.5}},
        {"linear": {"x": np.float32(0.5)}, "angular": {}},
        OfRclpy(),
        OfAnybody({"x": 0.5}),
    ],
)
def test_what_is_left_out_is_zero(said: Any) -> None:
    twist = Twist.deserialize(codec_of(TWIST).encode(said))
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.5, 0.0, 0.0)


def test_sequences_may_be_lists_or_arrays() -> None:
    for ranges in ([1.5, 2.5], np.array([1.5, 2.5])):
        said = {"header": {"frame_id": "laser"}, "ranges": ranges}
        scan = LaserScan.deserialize(codec_of(SCAN).encode(said))
        assert (list(scan.ranges), list(scan.intensities)) == ([1.5, 2.5], [])
        assert scan.header.frame_id == "laser"


def test_what_was_read_is_written_as_it_was() -> None:
    codec = codec_of(SCAN)
    payload = codec.encode({"ranges": [1.0, np.inf, np.nan], "range_max": 3.25})
    assert codec.encode(codec.decode(payload)) == payload


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"speed": 1.0}, "has no field 'speed'; it has linear, angular"),
        ({"linear": 1.0}, "expected a message or a dictionary, got float"),
        ({"linear": {"x": "fast"}}, "could not convert"),
        (STORE.types["geometry_msgs/msg/Point"](x=0.0, y=0.0, z=0.0), "got geometry_msgs/msg/Po"),
    ],
)
def test_what_is_no_such_message_is_refused(said: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words):
        codec_of(TWIST).encode(said)


def test_the_type_of_an_object_of_rclpy_follows_from_its_module() -> None:
    kind = type("Twist", (OfRclpy,), {"__module__": "geometry_msgs.msg._twist"})
    assert ros2_type_of(kind()) == "geometry_msgs/msg/Twist"
    assert ros2_type_of({"x": 1}) == ros2_type_of(OfAnybody({})) == ""
