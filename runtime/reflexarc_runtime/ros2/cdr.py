"""Messages of ROS 2 in CDR, the encoding in which they travel: read with their definitions."""

from functools import cache
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from reflexarc_runtime.messages.wire import MAX_PAYLOAD_BYTES
from reflexarc_runtime.ros2.ros_types import RosType

LITTLE_ENDIAN_CDR = b"\x00\x01"
"""First bytes of the encapsulation (DDS-XTYPES 1.3, 7.6.3.1.2); two of options follow."""
SECOND_NS = 1_000_000_000

_ENCAPSULATION_BYTES = 4


class UnusableMessageError(ValueError):
    """A message that cannot be used. Its text is one of a few, to be counted by reason."""


def read_cdr(payload: bytes, kind: RosType) -> Any:
    """The message in a payload.

    Raises:
        UnusableMessageError: not little-endian CDR, longer than 1 MiB, or not of this type.
    """
    if len(payload) > MAX_PAYLOAD_BYTES:
        raise UnusableMessageError("more than 1 MiB")
    if len(payload) < _ENCAPSULATION_BYTES or payload[:2] != LITTLE_ENDIAN_CDR:
        raise UnusableMessageError("no little-endian CDR")
    try:
        return message_types().deserialize_cdr(payload, kind.name)
    except (SerdeError, UnicodeDecodeError):
        raise UnusableMessageError(f"no {kind.name}") from None


@cache
def message_types() -> Any:
    """The definitions of Jazzy; the messages that we use are the same in every distribution."""
    return get_typestore(Stores.ROS2_JAZZY)


def stamp_ns(header: Any) -> int:
    """The stamp of a message, nanoseconds of the robot's clock."""
    return int(header.stamp.sec * SECOND_NS + header.stamp.nanosec)
