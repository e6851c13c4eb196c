"""What the guard takes for granted about a body; a log carries it."""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.one_line import from_one_line, in_one_line
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError

LEAST_MARGIN_M = 0.001
"""A point without a margin sweeps a line, and no beam's point lies on a line."""

RANGE_TOPICS = ("", "scan")

_SINCE = {"inertia": False, "ranges": "", "ranges_oldest_s": 0.25}
"""What came later, as older logs were driven: they do not name it."""

_require = partial(require, error=UsageError)


@dataclass(frozen=True)
class GuardSettings:
    """What the guard takes for granted about a body."""

    margin_m: float = 0.05
    """Distance that is kept from everything, on all sides."""
    footprint: Footprint = field(default_factory=Footprint)
    """Outline of the body; the ranges are measured from its origin."""
    delay_s: float = 0.0
    """From a command's arrival to the motion that it asks for."""
    deceleration_mps2: float | None = None
    """How hard the body brakes; None: at once."""
    evade_s: float = 0.3
    """How much longer a way must be free for an action to be preferred: who evades only at the last
    moment has nowhere left to go. 0: no action is preferred."""
    may_slow: bool = True
    """Whether a slower motion is tried before standstill."""
    inertia: bool = True
    """Whether a body that brakes in time is believed to change its motion in time as well."""
    ranges: str = ""
    """Topic from which the ranges come: scan; empty: what the policy sees tells them."""
    ranges_oldest_s: float = 0.25
    """How old ranges from a topic of their own may be; older ones are none."""

    def __post_init__(self) -> None:
        least, margin_m = LEAST_MARGIN_M, self.margin_m
        _require(least <= margin_m < math.inf, "guard.margin_m", f"{least:g} or more", margin_m)
        _require(0.0 <= self.delay_s < math.inf, "guard.delay_s", "0 or more", self.delay_s)
        _require(0.0 <= self.evade_s < math.inf, "guard.evade_s", "0 or more", self.evade_s)
        _require(self.ranges in RANGE_TOPICS, "guard.ranges", "scan", self.ranges)
        oldest_s = self.ranges_oldest_s
        _require(0.0 < oldest_s <= 10.0, "guard.ranges_oldest_s", "above 0, at most 10", oldest_s)
        braking = self.deceleration_mps2
        fits = braking is None or 0.0 < braking < math.inf
        _require(fits, "guard.deceleration_mps2", "above 0", braking)

    @classmethod
    def of(cls, contract: PolicyContract) -> Self:
        """The settings for the body that a policy learned with."""
        body = contract.body
        return cls(
            footprint=body.footprint,
            delay_s=body.actuation_delay_s,
            deceleration_mps2=body.deceleration_mps2,
        )

    @property
    def follows_mps2(self) -> float | None:
        """How fast a body's speed changes, as far as that counts; None: at once."""
        return self.deceleration_mps2 if self.inertia else None

    @property
    def ranges_oldest_ns(self) -> int:
        """`ranges_oldest_s` in nanoseconds."""
        return round(self.ranges_oldest_s * 1e9)

    def to_json(self) -> str:
        """One line, for a log's metadata."""
        return in_one_line(self)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read them back.

        Raises:
            LogError: not what `to_json` wrote.
        """
        return from_one_line(cls, text, "guard", _SINCE)
