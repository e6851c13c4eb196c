"""What a body does at most, whatever it is told.

They come from the body's own configuration: a world's file, flags of a bridge. No message and no
policy widens them.
"""

import math
from dataclasses import dataclass
from functools import partial

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError

FOR_EVER_NS = (1 << 63) - 1

_require = partial(require, error=ContractError)


@dataclass(frozen=True)
class BodyLimits:
    """What a body does at most, whatever it is told; by default it has no limits of its own."""

    linear_mps: float = math.inf
    """Largest speed ahead and back; 0: it does not move so at all."""
    lateral_mps: float = math.inf
    """Largest speed to the side."""
    angular_radps: float = math.inf
    """Largest angular speed."""
    acceleration_mps2: float = math.inf
    """Most that a speed grows in a second. It never delays a stop: slowing down is unlimited."""
    valid_for_s: float = math.inf
    """Longest time for which a command is obeyed, whatever it says itself."""

    def __post_init__(self) -> None:
        for name in ("linear_mps", "lateral_mps", "angular_radps"):
            value = getattr(self, name)
            _require(value >= 0.0, f"limits.{name}", "0 or more", value)
        for name in ("acceleration_mps2", "valid_for_s"):
            value = getattr(self, name)
            _require(value > 0.0, f"limits.{name}", "above 0", value)

    @property
    def valid_for_ns(self) -> int:
        """The longest validity in nanoseconds."""
        seconds = min(self.valid_for_s, FOR_EVER_NS / 1e9)
        return min(round(seconds * 1e9), FOR_EVER_NS)

    def narrowed(self, other: "BodyLimits") -> "BodyLimits":
        """The smaller of each of two limits."""
        return BodyLimits(
            min(self.linear_mps, other.linear_mps),
            min(self.lateral_mps, other.lateral_mps),
            min(self.angular_radps, other.angular_radps),
            min(self.acceleration_mps2, other.acceleration_mps2),
            min(self.valid_for_s, other.valid_for_s),
        )
