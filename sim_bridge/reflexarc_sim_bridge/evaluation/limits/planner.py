"""The range-limited planner: knows what lies within its view, exactly, and plans on its lattice.

It is no bound. It separates what senses could tell from what a policy makes of it: it knows the
true outlines of all that lies within range and field of view of its eye, through what stands in
front of it as well, and how it will move; of the rest it knows nothing and takes it for free. Ten
times a second it plans as far as it sees (`horizon.py`), as if its body obeyed at once and exactly.

As a contender: `reflexarc_sim_bridge.evaluation.limits.planner:Planner`.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.arrays import Actions, Mask
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.evaluation.driving.driver import Driver
from reflexarc_sim_bridge.evaluation.limits.horizon import plan
from reflexarc_sim_bridge.evaluation.limits.rows import Found, Lookout, bare, multiples_of
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

PLAN_S = 0.1
"""It plans anew so often, and at least at every step."""

_OFF_M = 1e-6


class Planner:
    """The planner among contenders, with the eye and the motions of the reference field.

    Args:
        contract: another eye, other motions.
    """

    def __init__(self, contract: PolicyContract | None = None) -> None:
        self.contract = contract or reference_contract()

    def driver(self, simulation: Simulation, contract: PolicyContract) -> Driver:
        """See `Knower`."""
        return PlanningDriver(simulation, contract)


@dataclass
class _Known:
    """What is known around one agent: a lattice of rows that begins where it was."""

    found: Found
    first: int
    """Number of the first step."""
    row: int
    """Where the agent is, if it obeyed."""
    x_m: float
    y_m: float


class PlanningDriver:
    """Plans for each agent of a simulation.

    Args:
        simulation: whose agents.
        contract: their eye and motions.

    Raises:
        UsageError: they turn, or do not go ahead at one speed.
    """

    def __init__(self, simulation: Simulation, contract: PolicyContract) -> None:
        prepare()
        multiples, aside_mps = multiples_of(contract)
        dt_s, retina = simulation.dt_s, contract.retina
        self._shifts = np.array(multiples, np.int64)
        self._row_m = aside_mps * dt_s
        self._ahead_m = contract.actions[0].linear_mps * dt_s
        self._view = retina.range_m, retina.fov_rad / 2
        self._horizon = max(1, math.ceil(retina.range_m / self._ahead_m))
        self._every = max(1, math.floor(PLAN_S / dt_s + _OFF_M))
        self._reach = 2 * self._horizon * int(np.abs(self._shifts).max())
        self._scratch = np.empty((2, 2, 2 * self._reach + 1))
        self._choices = np.zeros((self._every, 2 * self._reach + 1), np.int64)
        self._lookouts = self._lookouts_of(simulation)
        self._known: list[_Known | None] = [None] * len(simulation)
        self._plans = np.zeros((len(simulation), self._every), np.int64)
        self._step = 0
        self.wanted: Actions = np.zeros(len(simulation), np.int64)

    def drive(self, simulation: Simulation) -> Actions:
        """See `Driver`."""
        at = self._step % self._every
        places = zip(simulation.x_m.tolist(), simulation.y_m.tolist(), strict=True)
        for agent, (x_m, y_m) in enumerate(places):
            known = self._known[agent]
            if known is None or at == 0:
                self._plan(simulation, agent, x_m, y_m)
        self.wanted = self._plans[:, at].copy()
        self._follow()
        self._step += 1
        return self.wanted

    def begin_anew(self, agents: Mask) -> None:
        """See `Driver`."""
        for agent in np.flatnonzero(agents).tolist():
            self._known[agent] = None

    def _plan(self, simulation: Simulation, agent: int, x_m: float, y_m: float) -> None:
        """Fill the plan of an agent, from the step on that is due."""
        step, at = self._step, self._step % self._every
        known = self._known[agent]
        if known is None or not self._holds(known, x_m, y_m):
            known = self._look(simulation, agent, x_m, y_m)
        begin = step - known.first
        seen = known.found[begin : begin + self._horizon]
        motions = np.zeros(self._every - at, np.int64)
        lasts, chances = self._scratch
        form = self._shifts, known.row, self._ahead_m, self._row_m
        plan(seen, *form, *self._view, lasts, chances, self._choices, motions)
        self._plans[agent, at:] = motions
        self._known[agent] = known

    def _holds(self, known: _Known, x_m: float, y_m: float) -> bool:
        """Whether an agent is where it is thought to be, and all of its view is known."""
        is_there = abs(known.x_m - x_m) < _OFF_M and abs(known.y_m - y_m) < _OFF_M
        return is_there and self._step + self._horizon <= known.first + len(known.found)

    def _look(self, simulation: Simulation, agent: int, x_m: float, y_m: float) -> _Known:
        rows_m: Floats = y_m + self._row_m * np.arange(
            -self._reach, self._reach + 1, dtype=np.float64
        )
        lookout = self._lookouts[agent]
        found = lookout.look(x_m, rows_m, self._step, 2 * self._horizon)
        return _Known(found, self._step, self._reach, x_m, y_m)

    def _follow(self) -> None:
        """Note where the agents will be."""
        for known, action in zip(self._known, self.wanted.tolist(), strict=True):
            if known is not None:
                shift = int(self._shifts[action])
                known.row += shift
                known.x_m += self._ahead_m
                known.y_m += shift * self._row_m

    def _lookouts_of(self, simulation: Simulation) -> list[Lookout]:
        """One a world, for each of its agents."""
        left_m: Floats = self._row_m * self._shifts.astype(np.float64)
        seeds = simulation.params.agents.state["seed"].tolist()
        made = {
            seed: Lookout(bare(simulation.world.drawn(seed)), seed, self._ahead_m, left_m)
            for seed in set(seeds)
        }
        return [made[seed] for seed in seeds]
