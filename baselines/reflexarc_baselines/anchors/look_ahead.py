"""Look one step ahead: try each motion for some times, and take the one that stays free longest.

Source: D. Fox, W. Burgard, S. Thrun, "The dynamic window approach to collision avoidance", IEEE
Robotics & Automation Magazine 4(1), 1997: among the motions that are admissible the one with the
largest sum of heading, distance and velocity. Adapted to three motions:

    q(stay) = t(stay) + α,   q(left) = t(left),   q(right) = t(right)

t(motion) is the longest, over some hold times h, of the times until the strip that the body sweeps,
which does the motion for h and then goes ahead, meets a point in which a ray ended; at most the
horizon. The velocity's term is the same for all three, and the heading's has only two values, so α
is a preference to stay.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.headings import headings_rad
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import STAY, preferring_to_stay
from reflexarc_baselines.swept_strip import Path, free_on_legs_m
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = (
    "D. Fox, W. Burgard, S. Thrun, The dynamic window approach to collision avoidance, "
    "IEEE Robotics & Automation Magazine 4(1), 1997"
)


@dataclass(frozen=True)
class LookAhead:
    """Takes the motion after which the way is free longest."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "half_width_m": Span(0.02, 0.5),
        "longest_hold_s": Span(0.1, 3.0),
        "horizon_s": Span(0.5, 5.0),
        "preference_s": Span(1e-3, 1.0, is_log=True),
    }

    half_width_m: float = 0.15
    """Half the width of the strip; a narrow one slips between two rays."""
    holds: int = 4
    """How many hold times are tried."""
    longest_hold_s: float = 1.0
    """The longest of them; the others divide it evenly."""
    horizon_s: float = 3.0
    """What happens later counts for nothing."""
    preference_s: float = 0.1
    """α: how much longer another motion must be free before it leaves its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        eye, actions = self.contract.retina, len(self.contract.actions)
        reach_m, bearings = distances_m(retinas, eye), bearings_rad(eye)
        # What lies at the end of its range a ray does not tell from nothing.
        reach_m = np.where(reach_m < np.float32(eye.range_m), reach_m, np.float32(1e9))
        x_m, y_m = reach_m * np.cos(bearings), reach_m * np.sin(bearings)
        free_s = np.stack([self.free_s(x_m, y_m, row) for row in range(actions)], axis=1)
        return preferring_to_stay(free_s, self.preference_s)

    def free_s(self, x_m: Floats, y_m: Floats, row: int) -> Floats:
        """How long the body is free that does an action for the best of the hold times: (n,).

        Args:
            x_m: ahead, of the points in which rays ended: (n, rays).
            y_m: to the left.
            row: of the action.
        """
        shares = np.arange(1, self.holds + 1) / self.holds
        tried = [self._free_after_s(x_m, y_m, row, self.longest_hold_s * s) for s in shares]
        longest: Floats = np.minimum(reduce(np.maximum, tried), np.float32(self.horizon_s))
        return longest

    def _free_after_s(self, x_m: Floats, y_m: Floats, row: int, hold_s: float) -> Floats:
        action, ahead_mps = self.contract.actions[row], self.contract.actions[STAY].linear_mps
        speed_mps = math.hypot(action.linear_mps, action.lateral_mps)
        heading_rad = headings_rad(self.contract)[row]
        path = Path(heading_rad, speed_mps * hold_s, self.half_width_m)
        first_m, second_m = free_on_legs_m(x_m, y_m, path, ahead_mps * self.horizon_s)
        is_through = first_m >= np.float32(path.first_leg_m)
        after_s = np.float32(hold_s) + second_m / np.float32(ahead_mps)
        return np.where(is_through, after_s, first_m / np.float32(speed_mps))
