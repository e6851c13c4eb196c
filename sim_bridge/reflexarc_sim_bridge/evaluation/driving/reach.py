"""How far an agent gets away from where it began, before it first meets something.

The greatest distance from the start, not the last one and not the way: a body that circles, or goes
to and fro, gets nowhere.
"""

import numpy as np

from reflexarc_runtime.arrays import Mask
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.simulation.simulation import Simulation


class Reach:
    """Watches the agents of a simulation from now on.

    Args:
        simulation: its agents' places are read after every step.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._period_m = simulation.world.drawn(0).period_m
        self._start_x_m, self._last_y_m = simulation.x_m, simulation.y_m
        self._left_m = np.zeros(len(simulation))
        self._goes_on = np.ones(len(simulation), np.bool_)
        self.greatest_m: Floats = np.zeros(len(simulation))
        """So far: (agents,)."""

    def note(self, met: Mask) -> None:
        """Take down a step: where the agents are now, and which have met something in it."""
        self._goes_on &= ~met
        x_m, y_m = self._simulation.x_m, self._simulation.y_m
        self._left_m += self._unwrapped(y_m - self._last_y_m)
        self._last_y_m = y_m
        away_m = np.hypot(x_m - self._start_x_m, self._left_m)
        self.greatest_m = np.where(
            self._goes_on, np.maximum(self.greatest_m, away_m), self.greatest_m
        )

    def _unwrapped(self, step_m: Floats) -> Floats:
        """A step to the left: a jump from one side of the period to the other is none."""
        if self._period_m is None:
            return step_m
        return step_m - self._period_m * np.rint(step_m / self._period_m)
