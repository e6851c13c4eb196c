"""A track: what many agents did in one cell, step by step. Metrics are functions of it.

Arrays over steps are (steps, agents): what was so before each step, and what the step did. Agents
of one world stand side by side: agent w · lanes + l is number l in world w.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Floats32 = npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Circumstances:
    """What holds for the whole of a track: metres, seconds, radians."""

    dt_s: float
    forward_mps: float
    """Speed of the action that stays on its way."""
    lateral_mps: float
    """Largest sideways speed of an action; 0 for a body that turns."""
    angular_radps: float
    """Largest turning speed of an action; 0 for one that moves sideways."""
    radius_m: float
    """Of the body."""
    obstacle_radius_m: float
    """R: half the mean lateral width of what is scattered, plus the body's radius."""
    latency_s: float
    """From a look to the motion that it causes, on top of one step."""
    range_m: float
    """As far as its eye sees."""
    fov_rad: float
    width_m: float
    """Of the track or its period, laterally."""
    free_path_m: float
    """Mean free path of a body that never steers."""
    lateral: npt.NDArray[np.int8]
    """−1 right, 0 stay, 1 left: what each action of the contract does: (actions,)."""
    respawns: bool = True
    """Whether an agent stands elsewhere after a contact; else it passes through as a ghost."""
    has_sides: bool = True
    """Whether lateral places are within [0, width_m], as in all worlds but unbounded ones."""

    @property
    def turns(self) -> bool:
        """Whether the body turns."""
        return self.angular_radps > 0.0

    @property
    def dodge_s(self) -> float:
        """How long it takes to get out of the way of an obstacle: to go R aside.

        R/w sideways. A body that turns at ω and goes v is (v/ω)(1 − cos ωt) aside; where that never
        reaches R, when it is farthest aside.
        """
        if self.lateral_mps > 0.0:
            return self.obstacle_radius_m / self.lateral_mps
        if not (self.turns and self.forward_mps > 0.0):
            return math.inf
        share = self.obstacle_radius_m * self.angular_radps / self.forward_mps
        return math.acos(max(1.0 - share, -1.0)) / self.angular_radps

    @property
    def threat_s(self) -> float:
        """T_h = 2(R/w + τ): what would be met sooner is a threat."""
        return 2.0 * (self.dodge_s + self.latency_s)


@dataclass(frozen=True)
class Track:
    """What many agents did in one cell."""

    circumstances: Circumstances
    lanes: int
    """Agents in each world."""
    x_m: Floats
    """Ahead."""
    y_m: Floats
    """To the left, within the period."""
    heading_rad: Floats
    progress_m: Floats
    """Along x, by the step."""
    actions: npt.NDArray[np.int8]
    """Index in the contract."""
    met: Bools
    """Whether the step ended in a contact; the agent then stands elsewhere, at the same x."""
    clearance_m: Floats32
    """From the body's outline to the nearest obstacle, at most `range_m` from its middle; 0 in
    contact."""
    ahead_s: Floats32
    """Time to the first contact if it went straight on at forward speed, obstacles moving as they
    do; 0 in contact, infinity where it meets nothing of what is within `range_m` now."""

    @property
    def steps(self) -> int:
        """Steps of each agent."""
        return len(self.met)

    @property
    def worlds(self) -> int:
        """How many worlds."""
        return int(self.met.shape[1]) // self.lanes

    @property
    def agents(self) -> int:
        """How many agents."""
        return int(self.met.shape[1])

    @property
    def lateral(self) -> npt.NDArray[np.int8]:
        """−1 right, 0 stay, 1 left: what each step wanted: (steps, agents)."""
        return self.circumstances.lateral[self.actions]

    @property
    def goes_on(self) -> Bools:
        """Whether a step leads to the next one, with no new place between: (steps − 1, agents)."""
        return ~self.met[:-1] | (not self.circumstances.respawns)

    @property
    def left_m(self) -> Floats:
        """How far each step but the last led to the left, across the seam of a period too.

        Of a step that ended in a contact it is where the agent was put: see `goes_on`.
        """
        width_m, changes = self.circumstances.width_m, np.diff(self.y_m, axis=0)
        if self.circumstances.has_sides:
            changes -= width_m * np.round(changes / width_m)
        return changes

    def over_worlds(self, per_agent: npt.ArrayLike) -> Floats:
        """Sums over the agents of each world: (agents, …) → (worlds, …)."""
        values = np.asarray(per_agent, np.float64)
        sums: Floats = values.reshape(self.worlds, self.lanes, *values.shape[1:]).sum(axis=1)
        return sums
