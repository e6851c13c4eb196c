"""Where a robot is, in its own words: odometry and transforms, from ROS 2 to Foxglove's messages.

`nav_msgs/Odometry` says a pose in the frame of its header, `odom` (REP 105), and becomes
`foxglove.PoseInFrame`; its speeds and covariances are left out. `tf2_msgs/TFMessage` holds
transforms from a parent frame to a child; each becomes a `foxglove.FrameTransform`. Lengths are
metres, rotations unit quaternions, times those of the robot's clock. Nothing here decides anything:
it is for the log.
"""

import math
from typing import Any

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from reflexarc_runtime.messages.codec import timestamp
from reflexarc_runtime.ros2.cdr import UnusableMessageError, read_cdr, stamp_ns
from reflexarc_runtime.ros2.ros_types import ODOMETRY, TF_MESSAGE

MAX_TF_BYTES = 1 << 16
"""Of one message: 700 transforms. Reading it must not hold up the bridge."""
MAX_FRAME_NAME = 256
ROTATION_TOLERANCE = 0.01
"""How far from 1 the length of a quaternion may be."""


def decode_odometry(payload: bytes) -> PoseInFrame:
    """Read `nav_msgs/Odometry`.

    Raises:
        UnusableMessageError: it is none, or names no frame, or its numbers are no pose.
    """
    message = read_cdr(payload, ODOMETRY)
    pose = message.pose.pose
    return PoseInFrame(
        timestamp=timestamp(stamp_ns(message.header)),
        frame_id=_frame(message.header.frame_id),
        pose=Pose(position=_vector(pose.position), orientation=_rotation(pose.orientation)),
    )


def decode_transforms(payload: bytes) -> list[FrameTransform]:
    """Read `tf2_msgs/TFMessage`: all of its transforms, or none if one cannot be used.

    Raises:
        UnusableMessageError: it is none, too long, or one names no frame or is no transform.
    """
    if len(payload) > MAX_TF_BYTES:
        raise UnusableMessageError(f"more than {MAX_TF_BYTES >> 10} KiB")
    return [_transform(one) for one in read_cdr(payload, TF_MESSAGE).transforms]


def _transform(message: Any) -> FrameTransform:
    return FrameTransform(
        timestamp=timestamp(stamp_ns(message.header)),
        parent_frame_id=_frame(message.header.frame_id),
        child_frame_id=_frame(message.child_frame_id),
        translation=_vector(message.transform.translation),
        rotation=_rotation(message.transform.rotation),
    )


def _frame(name: str) -> str:
    """The name of a frame; tf2 leaves out the slash that ROS 1 began it with."""
    plain = name.removeprefix("/")
    if not 0 < len(plain) <= MAX_FRAME_NAME:
        raise UnusableMessageError("a frame without a name")
    return plain


def _vector(point: Any) -> Vector3:
    if not all(map(math.isfinite, (point.x, point.y, point.z))):
        raise UnusableMessageError("a place that is none")
    return Vector3(x=point.x, y=point.y, z=point.z)


def _rotation(turn: Any) -> Quaternion:
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)
    if not abs(length - 1.0) <= ROTATION_TOLERANCE:
        raise UnusableMessageError("a rotation that is none")
    return Quaternion(x=turn.x, y=turn.y, z=turn.z, w=turn.w)
