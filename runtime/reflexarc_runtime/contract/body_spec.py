"""The body that a policy learned with: its outline, and how late and how hard it obeys."""

import math
from dataclasses import dataclass, field
from functools import partial

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError

_require = partial(require, error=ContractError)


@dataclass(frozen=True)
class Footprint:
    """Outline of a body on the ground: a point, a circle or a rectangle, in the body's frame.

    The origin is the point about which the body turns. A circle has a radius, a rectangle the
    other three; a point has none of them.
    """

    radius_m: float = 0.0
    """Radius of a round body."""
    ahead_m: float = 0.0
    """From the origin to the front of a rectangular body."""
    behind_m: float = 0.0
    """From the origin to its rear."""
    half_width_m: float = 0.0
    """From the origin to its left side, and to its right side."""

    def __post_init__(self) -> None:
        sides = (self.ahead_m, self.behind_m, self.half_width_m)
        for size in (self.radius_m, *sides):
            _require(0.0 <= size < math.inf, "footprint", "sizes from 0 on", size)
        one = not (self.radius_m and any(sides))
        _require(one, "footprint", "a radius or a rectangle", "both")

    @property
    def reach_m(self) -> float:
        """Distance from the origin to the farthest point."""
        corner_m = math.hypot(max(self.ahead_m, self.behind_m), self.half_width_m)
        return max(self.radius_m, corner_m)


@dataclass(frozen=True)
class BodySpec:
    """A body; by default a point that obeys at once and stops at once."""

    footprint: Footprint = field(default_factory=Footprint)
    actuation_delay_s: float = 0.0
    """From a command's arrival to the motion that it asks for."""
    deceleration_mps2: float | None = None
    """How hard it brakes; None: at once."""

    def __post_init__(self) -> None:
        delay_s, braking = self.actuation_delay_s, self.deceleration_mps2
        _require(0.0 <= delay_s < math.inf, "actuation_delay_s", "0 or more", delay_s)
        fits = braking is None or 0.0 < braking < math.inf
        _require(fits, "deceleration_mps2", "positive, or null", braking)
