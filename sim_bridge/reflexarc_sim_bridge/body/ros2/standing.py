"""Whether a robot stands, by its own odometry (`nav_msgs/Odometry`, in CDR).

It stands when it has said so for `SURE_NS` without a gap as long as that. What it says is believed
within bounds only: see `silence.py`.
"""

import math
import struct
from dataclasses import dataclass

SLOW_MPS, SLOW_RADPS = 0.01, 0.01
"""Below both of these a base stands: wheel encoders count noise, too."""
SURE_NS = 200_000_000

_LITTLE_ENDIAN_CDR = b"\x00\x01"
_SPEEDS = struct.Struct("<6d")
_COVARIANCE_BYTES = 36 * 8
_TAIL_BYTES = _SPEEDS.size + _COVARIANCE_BYTES
_LEAST_BYTES = 4 + 16 + 7 * 8 + 2 * _COVARIANCE_BYTES + _SPEEDS.size


@dataclass(frozen=True, slots=True)
class Standing:
    """What was heard of an odometry."""

    since_ns: int | None = None
    """Since when it has said that the robot stands; None: it moves, or nothing is known."""
    heard_ns: int = 0
    """When it was heard last."""

    def heard(self, payload: bytes, now_ns: int) -> "Standing":
        """What is known after another message."""
        if not says_standing(payload):
            return Standing(None, now_ns)
        has_gap = self.since_ns is None or now_ns - self.heard_ns >= SURE_NS
        return Standing(now_ns if has_gap else self.since_ns, now_ns)

    def is_sure(self, now_ns: int) -> bool:
        """Whether it has stood for long enough, and still says so."""
        if self.since_ns is None or now_ns - self.heard_ns >= SURE_NS:
            return False
        return self.heard_ns - self.since_ns >= SURE_NS


def says_standing(payload: bytes) -> bool:
    """Whether a message says that the base stands; one that cannot be read does not.

    It ends with the six speeds of its twist and their 36 covariances, all doubles.
    """
    if payload[:2] != _LITTLE_ENDIAN_CDR or len(payload) < _LEAST_BYTES:
        return False
    x, y, z, *turns = _SPEEDS.unpack_from(payload, len(payload) - _TAIL_BYTES)
    # What is not a number is not below anything.
    return math.hypot(x, y, z) < SLOW_MPS and math.hypot(*turns) < SLOW_RADPS
