"""How a layer moves as a whole: the place of every obstacle is a closed form of the time."""

import math
from dataclasses import dataclass
from typing import TypeAlias

from reflexarc_sim_bridge.worlds.checks import require_within


@dataclass(frozen=True)
class Drift:
    """A layer that moves at one velocity, for ever."""

    ahead_mps: float = 0.0
    left_mps: float = 0.0

    def __post_init__(self) -> None:
        require_within("drift.ahead_mps", self.ahead_mps, -100.0, 100.0)
        require_within("drift.left_mps", self.left_mps, -100.0, 100.0)

    @property
    def fastest_mps(self) -> float:
        """Its greatest speed."""
        return math.hypot(self.ahead_mps, self.left_mps)


@dataclass(frozen=True)
class Swing:
    """A layer that goes to and fro: displacement · sin(2π t / period)."""

    ahead_m: float = 0.0
    left_m: float = 1.0
    period_s: float = 4.0

    def __post_init__(self) -> None:
        require_within("swing.ahead_m", self.ahead_m, -100.0, 100.0)
        require_within("swing.left_m", self.left_m, -100.0, 100.0)
        require_within("swing.period_s", self.period_s, 0.1, 1e6)

    @property
    def fastest_mps(self) -> float:
        """Its greatest speed: 2π / period · displacement."""
        return math.tau / self.period_s * math.hypot(self.ahead_m, self.left_m)


Motion: TypeAlias = Drift | Swing
