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


def read_cdr(payload: bytes, kind: RosType, most_bytes: int = MAX_PAYLOAD_BYTES) -> Any:
    """The message in a payload.

    Args:
        payload: with its encapsulation.
        kind: what it should be.
        most_bytes: how long it may be.

    Raises:
        UnusableMessageError: not little-endian CDR, longer than that, or not of this type.
    """
    if len(payload) > most_bytes:
        raise UnusableMessageError(f"more than {most_bytes >> 20} MiB")
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


def write_cdr(message: Any, kind: RosType) -> bytes:
    """A message as its payload, little-endian."""
    return bytes(message_types().serialize_cdr(message, kind.name, little_endian=True))
