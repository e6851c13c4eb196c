"""Our own streams as messages of ROS 2: which type each becomes, and how.

Lengths are metres, angles radians counter-clockwise, as ours are. A range of +inf is nothing met,
−inf too near, NaN unknown (REP 117). What ROS has no place for is left out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.message import Message

from reflexarc_runtime.messages.topics import ODOMETRY
from reflexarc_runtime.messages_pb2 import Command
from reflexarc_runtime.ros2.cdr import SECOND_NS, message_types

_ROS_LEVELS = 10
"""Foxglove's levels are 1 to 5, those of rcl_interfaces/Log 10 to 50."""
_NO_COVARIANCE = np.zeros(36)


@dataclass(frozen=True)
class About:
    """What a conversion needs beside the message."""

    robot: str
    wall_ns: int
    """When it was, on the wall clock."""
    range_max_m: float = 0.0
    """A distance that is beyond every range of the scanner."""
    child_frame: str = ""
    """The frame whose place an odometry says."""
    scan_frame: str = ""
    """The scanner's own frame; empty: the one that the scan names."""


@dataclass(frozen=True)
class RosForm:
    """What a stream becomes."""

    type_name: str
    kind: type[Message]
    """What it is in the log."""
    convert: Callable[[Any, About], Any]


def form_of(schema: str, name: str) -> RosForm | None:
    """What a stream becomes by its message and its name in the log; None: it is left out."""
    if schema == PoseInFrame.DESCRIPTOR.full_name and name.endswith(ODOMETRY.name):
        return _ODOMETRY
    return FORMS.get(schema)


def scan_frame_of(scan: LaserScan, about: About) -> FrameTransform:
    """Where a scanner's own frame is in the one that its scan names."""
    place, turn = scan.pose.position, scan.pose.orientation
    is_turned = any((turn.x, turn.y, turn.z, turn.w))
    return FrameTransform(
        parent_frame_id=scan.frame_id or about.robot,
        child_frame_id=about.scan_frame,
        translation=Vector3(x=place.x, y=place.y, z=place.z),
        rotation=turn if is_turned else Quaternion(w=1.0),
    )


def _made(type_name: str, /, **fields: Any) -> Any:
    return message_types().types[type_name](**fields)


def _header(about: About, frame: str) -> Any:
    seconds, nanoseconds = divmod(about.wall_ns, SECOND_NS)
    stamp = _made("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
    return _made("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def _scan(scan: LaserScan, about: About) -> Any:
    ranges_m = np.asarray(scan.ranges, np.float64)
    known = (ranges_m > 0.0) | (ranges_m == -np.inf)
    steps = max(1, len(ranges_m) - 1)
    return _made(
        "sensor_msgs/msg/LaserScan",
        header=_header(about, about.scan_frame or scan.frame_id or about.robot),
        angle_min=scan.start_angle,
        angle_max=scan.end_angle,
        angle_increment=(scan.end_angle - scan.start_angle) / steps,
        time_increment=0.0,
        scan_time=0.0,
        range_min=0.0,
        range_max=about.range_max_m,
        ranges=np.where(known, ranges_m, np.nan).astype(np.float32),
        intensities=np.asarray(scan.intensities, np.float32),
    )


def _image(image: RawImage, about: About) -> Any:
    return _made(
        "sensor_msgs/msg/Image",
        header=_header(about, about.robot),
        height=image.height,
        width=image.width,
        encoding=image.encoding,
        is_bigendian=0,
        step=image.step,
        data=np.frombuffer(image.data, np.uint8),
    )


def _compressed(image: CompressedImage, about: About) -> Any:
    return _made(
        "sensor_msgs/msg/CompressedImage",
        header=_header(about, image.frame_id or about.robot),
        format=image.format,
        data=np.frombuffer(image.data, np.uint8),
    )


def _transform(transform: FrameTransform, about: About) -> Any:
    shift, turn = transform.translation, transform.rotation
    one = _made(
        "geometry_msgs/msg/TransformStamped",
        header=_header(about, transform.parent_frame_id),
        child_frame_id=transform.child_frame_id,
        transform=_made(
            "geometry_msgs/msg/Transform",
            translation=_made("geometry_msgs/msg/Vector3", x=shift.x, y=shift.y, z=shift.z),
            rotation=_turn(turn),
        ),
    )
    return _made("tf2_msgs/msg/TFMessage", transforms=[one])


def _pose(message: PoseInFrame) -> Any:
    place = message.pose.position
    return _made(
        "geometry_msgs/msg/Pose",
        position=_made("geometry_msgs/msg/Point", x=place.x, y=place.y, z=place.z),
        orientation=_turn(message.pose.orientation),
    )


def _turn(turn: Any) -> Any:
    return _made("geometry_msgs/msg/Quaternion", x=turn.x, y=turn.y, z=turn.z, w=turn.w)


def _pose_stamped(message: PoseInFrame, about: About) -> Any:
    header = _header(about, message.frame_id)
    return _made("geometry_msgs/msg/PoseStamped", header=header, pose=_pose(message))


def _odometry(message: PoseInFrame, about: About) -> Any:
    """Its speeds are not in the log: they are zero, as are the covariances that nobody knows."""
    standing = _twist(0.0, 0.0, 0.0)
    return _made(
        "nav_msgs/msg/Odometry",
        header=_header(about, message.frame_id),
        child_frame_id=about.child_frame or about.robot,
        pose=_made(
            "geometry_msgs/msg/PoseWithCovariance", pose=_pose(message), covariance=_NO_COVARIANCE
        ),
        twist=_made(
            "geometry_msgs/msg/TwistWithCovariance", twist=standing, covariance=_NO_COVARIANCE
        ),
    )


def _twist(linear_mps: float, lateral_mps: float, angular_radps: float) -> Any:
    vector = "geometry_msgs/msg/Vector3"
    return _made(
        "geometry_msgs/msg/Twist",
        linear=_made(vector, x=linear_mps, y=lateral_mps, z=0.0),
        angular=_made(vector, x=0.0, y=0.0, z=angular_radps),
    )


def _command(command: Command, about: About) -> Any:
    twist = _twist(command.linear_mps, command.lateral_mps, command.angular_radps)
    header = _header(about, about.robot)
    return _made("geometry_msgs/msg/TwistStamped", header=header, twist=twist)


def _log(log: Log, about: About) -> Any:
    return _made(
        "rcl_interfaces/msg/Log",
        stamp=_header(about, "").stamp,
        level=_ROS_LEVELS * log.level,
        name=log.name,
        msg=log.message,
        file=log.file,
        function="",
        line=log.line,
    )


_ODOMETRY = RosForm("nav_msgs/msg/Odometry", PoseInFrame, _odometry)
FORMS: Mapping[str, RosForm] = {
    form.kind.DESCRIPTOR.full_name: form
    for form in (
        RosForm("sensor_msgs/msg/LaserScan", LaserScan, _scan),
        RosForm("sensor_msgs/msg/Image", RawImage, _image),
        RosForm("sensor_msgs/msg/CompressedImage", CompressedImage, _compressed),
        RosForm("tf2_msgs/msg/TFMessage", FrameTransform, _transform),
        RosForm("geometry_msgs/msg/PoseStamped", PoseInFrame, _pose_stamped),
        RosForm("geometry_msgs/msg/TwistStamped", Command, _command),
        RosForm("rcl_interfaces/msg/Log", Log, _log),
    )
}
"""By the full name of our message."""
