"""Motions as messages of ROS 2, in CDR."""

from typing import Any

from reflexarc_runtime.ros2.cdr import SECOND_NS, message_types
from reflexarc_runtime.ros2.ros_types import TWIST, TWIST_STAMPED
from reflexarc_sim_bridge.body.gate.limits import Twist


def encode_twist(motion: Twist) -> bytes:
    """A motion as `geometry_msgs/Twist`."""
    return bytes(message_types().serialize_cdr(_twist(motion), TWIST.name, little_endian=True))


def encode_twist_stamped(motion: Twist, time_ns: int, frame_id: str) -> bytes:
    """A motion as `geometry_msgs/TwistStamped`."""
    types = message_types().types
    seconds, nanoseconds = divmod(time_ns, SECOND_NS)
    stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame_id)
    message = types[TWIST_STAMPED.name](header=header, twist=_twist(motion))
    return bytes(message_types().serialize_cdr(message, TWIST_STAMPED.name, little_endian=True))


def _twist(motion: Twist) -> Any:
    types = message_types().types
    vector = types["geometry_msgs/msg/Vector3"]
    return types[TWIST.name](
        linear=vector(x=motion.linear_mps, y=motion.lateral_mps, z=0.0),
        angular=vector(x=0.0, y=0.0, z=motion.angular_radps),
    )
