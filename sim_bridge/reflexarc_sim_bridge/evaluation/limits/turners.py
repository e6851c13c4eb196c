"""How far a body that turns can come before its first contact: two bounds of the best possible.

Its places lie on no lattice, so the farthest is not computed exactly. Instead:

- `most_reached_m`, an upper bound: straight on at full speed for the whole time. Nobody beats it,
  and where obstacles stand in the way nobody attains it.
- `least_reached_m`, a lower bound: as far as a search with all knowledge came. Whatever it reached
  was driven in the simulation, step by step, so it can be reached; the best possible is farther,
  and so may be a contender.

The search is a beam: of the places reached so far it keeps a few for each start, those
farthest away, at most one in each small cell of place and heading, and drives on from each
by every motion for a while.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.track import Bools, Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import WorldSource

BEAM = 16
"""Places that are kept for each start."""
HELD_S = 0.2
"""Every motion is driven for so long at a time."""

_CELL_M, _CELL_RAD = 0.25, math.radians(20.0)
_SHORT = RetinaSpec(rays=1, range_m=0.01)
"""It sees nothing; lists of near obstacles are then of those that can be met."""
_NOT_YET = -(1 << 62)


def most_reached_m(contract: PolicyContract, time_s: float) -> float:
    """Upper bound of the distance from the start: metres."""
    speeds = [math.hypot(action.linear_mps, action.lateral_mps) for action in contract.actions]
    return max(speeds) * time_s


def least_reached_m(
    contender: Contender,
    cell: SuiteCell,
    suite: Suite,
    setting: Setting,
    seeds: npt.NDArray[np.uint64] | None = None,
) -> Floats:
    """Lower bound of the best possible distance, from where a drive begins: (worlds · lanes,).

    Args:
        contender: whose motions, rate and body.
        cell: where.
        suite: how many worlds and lanes, and for how long.
        setting: at which rate, with which body.
        seeds: of the worlds, (suite.worlds,); None: the test seeds.

    Raises:
        UsageError: it does not turn.
    """
    if not contender.turns:
        raise UsageError(f"{contender.name}: expected a body that turns")
    source = worlds_for(cell.source, contender, setting)
    seeds = np.repeat(test_seeds(suite.worlds) if seeds is None else seeds, suite.lanes)
    contract = PolicyContract(retina=_SHORT, actions=contender.contract.actions)
    return _Beam(source, contract, seeds).search(suite.turner_s)


class _Beam:
    """Places of every start, driven on together in one simulation."""

    def __init__(
        self, source: WorldSource, contract: PolicyContract, seeds: npt.NDArray[np.uint64]
    ) -> None:
        self._motions = len(contract.actions)
        self._all = Simulation(source, contract, np.repeat(seeds, BEAM * self._motions))
        self._shape = len(seeds), BEAM, self._motions
        self._dt_s = self._all.dt_s
        self._period_m = source.drawn(0).period_m or math.inf
        first = Simulation(source, contract, seeds).params.agents.state
        self._places = np.repeat(first[:, np.newaxis], BEAM, axis=1)
        self._away_m = np.zeros((len(seeds), BEAM, 2))
        self._is_there = np.arange(BEAM) == np.zeros((len(seeds), 1))

    def search(self, time_s: float) -> Floats:
        """Greatest distance of each start: (starts,)."""
        held = max(1, round(HELD_S / self._dt_s))
        farthest_m = np.zeros(self._shape[0])
        for _ in range(round(time_s / self._dt_s) // held):
            reached_m, is_there = self._drive_on(held)
            distances_m = np.where(is_there, np.hypot(*np.moveaxis(reached_m, -1, 0)), -1.0)
            farthest_m = np.maximum(farthest_m, distances_m.max(axis=(1, 2)))
            self._keep(reached_m, distances_m)
        return farthest_m

    def _drive_on(self, steps: int) -> tuple[Floats, Bools]:
        """Every motion from every place: how far from the start, and who met nothing."""
        agents = self._all.params.agents
        own_world = agents.state["world"].copy()
        agents.state[:] = np.repeat(self._places, self._motions, axis=1).reshape(-1)
        agents.state["world"] = own_world
        agents.layer_cells[:] = _NOT_YET
        stand = np.repeat(self._is_there, self._motions, axis=1).reshape(self._shape)
        actions = np.tile(np.arange(self._motions), len(agents.state) // self._motions)
        before_m = np.stack([self._all.x_m, self._all.y_m], axis=1)
        has_met = np.zeros(len(agents.state), np.bool_)
        for _ in range(steps):
            has_met |= self._all.step(actions)
        moved_m = np.stack([self._all.x_m, self._all.y_m], axis=1) - before_m
        if math.isfinite(self._period_m):
            moved_m[:, 1] -= self._period_m * np.round(moved_m[:, 1] / self._period_m)
        reached_m = self._away_m[:, :, np.newaxis] + moved_m.reshape(*self._shape, 2)
        return reached_m, stand & ~has_met.reshape(self._shape)

    def _keep(self, reached_m: Floats, distances_m: Floats) -> None:
        """Keep the farthest of each start that lie in different cells."""
        state = self._all.params.agents.state.reshape(self._shape)
        for start in range(self._shape[0]):
            order = np.argsort(-distances_m[start].reshape(-1), kind="stable")
            order = order[distances_m[start].reshape(-1)[order] >= 0.0]
            places_m = reached_m[start].reshape(-1, 2)[order]
            headings = state[start]["heading_rad"].reshape(-1)[order]
            cells = np.column_stack([places_m // _CELL_M, headings // _CELL_RAD])
            chosen = order[np.sort(np.unique(cells, axis=0, return_index=True)[1])][:BEAM]
            self._places[start, : len(chosen)] = state[start].reshape(-1)[chosen]
            self._away_m[start, : len(chosen)] = reached_m[start].reshape(-1, 2)[chosen]
            self._is_there[start] = np.arange(BEAM) < len(chosen)
