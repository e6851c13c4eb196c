"""Drives a contender through a cell, and writes down what it did."""

import math
from dataclasses import dataclass
from typing import cast

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_sim_bridge.evaluation.driving.crowd_guard import CrowdGuard
from reflexarc_sim_bridge.evaluation.driving.driver import Driver, Knower
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.metrics.edge_index import obstacle_radius_m
from reflexarc_sim_bridge.evaluation.metrics.track import Circumstances, Track
from reflexarc_sim_bridge.evaluation.protocol.clutter import free_path_m
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.surroundings import AgentSurroundings
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import AfterContact, Edges, World, WorldSource

DISCARDED_M = 10.0
"""Driven before the counting begins: an agent begins at a place drawn evenly, not where it would
have come."""
_USUAL_PATH_M, _USUAL_RADIUS_M = 2.78, 0.45
"""Of the reference field, where a world scatters nothing."""


@dataclass(frozen=True)
class Extent:
    """How many steps are driven, and how many of them are counted."""

    discarded: int
    counted: int


def drive(
    contender: Contender,
    cell: SuiteCell,
    suite: Suite,
    setting: Setting,
    seeds: npt.NDArray[np.uint64] | None = None,
) -> Track:
    """Drive through all worlds of a cell.

    Args:
        contender: who drives.
        cell: where.
        suite: how much of it.
        setting: at which rate, with which body.
        seeds: of the worlds, (suite.worlds,); None: the test seeds.

    Raises:
        ReflexarcError: a contract that the simulator, or the guard, does not support.
    """
    worlds = worlds_for(cell.source, contender, setting)
    seeds = test_seeds(suite.worlds) if seeds is None else seeds
    circumstances = circumstances_of(worlds, contender.contract, cell)
    extent = extent_of(circumstances, suite)
    simulation, driver = start(worlds, contender, np.repeat(seeds, suite.lanes), all_round=True)
    recorder = _Recorder(circumstances, suite.lanes, extent.counted, simulation)
    for step in range(-extent.discarded, extent.counted):
        simulation.sense()
        actions = driver.drive(simulation)
        if step >= 0:
            recorder.before(step, driver.wanted)
        met = simulation.step(actions)
        if step >= 0:
            recorder.after(step, met)
        driver.begin_anew(met)
    return recorder.track()


def start(
    worlds: WorldSource,
    contender: Contender,
    seeds: npt.NDArray[np.uint64],
    lanes: npt.NDArray[np.uint64] | None = None,
    *,
    all_round: bool = False,
) -> tuple[Simulation, Driver]:
    """Agents at their places, and who drives them.

    Args:
        worlds: as `worlds_for` gives them.
        contender: who drives.
        seeds: one an agent: (n,).
        lanes: tell agents of one seed apart: see `Simulation`.
        all_round: whether what lies behind is kept, too, for who measures clearances.
    """
    contract, dt_s = contender.contract, worlds.drawn(0).dt_s
    if hasattr(contender.policy, "driver"):
        if contender.is_guarded:
            raise UsageError(
                f"{contender.name}: expected no guard, as it does not drive by its eye"
            )
        simulation = Simulation(worlds, contract, seeds, lanes, all_round=all_round)
        return simulation, cast("Knower", contender.policy).driver(simulation, contract)
    crowd = None
    if contender.is_guarded:
        crowd = CrowdGuard(GuardSettings.of(contract), contract, dt_s)
    moves_by = contract if crowd is None else crowd.contract
    simulation = Simulation(worlds, moves_by, seeds, lanes, all_round=all_round)
    return simulation, Pilot(contender.policy, contract, len(seeds), dt_s, crowd)


def extent_of(circumstances: Circumstances, suite: Suite) -> Extent:
    """Turners are watched from their start on; who moves sideways is counted over a distance."""
    dt_s = circumstances.dt_s
    if circumstances.turns:
        return Extent(0, max(1, round(suite.turner_s / dt_s)))
    step_m = circumstances.forward_mps * dt_s
    counted_m = suite.free_paths * circumstances.free_path_m
    return Extent(math.ceil(DISCARDED_M / step_m), max(1, math.ceil(counted_m / step_m)))


def circumstances_of(
    worlds: WorldSource, contract: PolicyContract, cell: SuiteCell
) -> Circumstances:
    """What holds while a contract's body drives through the worlds of a cell."""
    world, actions = worlds.drawn(0), contract.actions
    scatters = any(isinstance(layer, Scatter) for layer in world.layers)
    return Circumstances(
        dt_s=world.dt_s,
        forward_mps=actions[0].linear_mps,
        lateral_mps=max(abs(action.lateral_mps) for action in actions),
        angular_radps=max(abs(action.angular_radps) for action in actions),
        radius_m=world.chassis.radius_m,
        obstacle_radius_m=obstacle_radius_m(world) if scatters else _USUAL_RADIUS_M,
        latency_s=_latency_s(world),
        range_m=contract.retina.range_m,
        fov_rad=contract.retina.fov_rad,
        width_m=world.width_m,
        free_path_m=cell.free_path_m or free_path_m(world) or _USUAL_PATH_M,
        lateral=_lateral(contract),
        respawns=world.chassis.after_contact is not AfterContact.GHOST,
        has_sides=world.edges is not Edges.UNBOUNDED,
    )


def _latency_s(world: World) -> float:
    return world.latency_steps * world.dt_s + world.chassis.lag_s


def _lateral(contract: PolicyContract) -> npt.NDArray[np.int8]:
    wishes = [action.lateral_mps + action.angular_radps for action in contract.actions]
    return np.sign(wishes).astype(np.int8)


class _Recorder:
    """Arrays that are filled step by step."""

    def __init__(
        self, circumstances: Circumstances, lanes: int, steps: int, simulation: Simulation
    ) -> None:
        shape = steps, len(simulation)
        self._circumstances, self._lanes, self._simulation = circumstances, lanes, simulation
        self._surroundings = AgentSurroundings(simulation, circumstances.forward_mps)
        self._x_m, self._y_m, self._heading_rad = (np.empty(shape) for _ in range(3))
        self._progress_m = np.empty(shape)
        self._actions, self._met = np.empty(shape, np.int8), np.empty(shape, np.bool_)
        self._clearance_m, self._ahead_s = (np.empty(shape, np.float32) for _ in range(2))

    def before(self, step: int, wanted: Actions) -> None:
        simulation = self._simulation
        self._x_m[step], self._y_m[step] = simulation.x_m, simulation.y_m
        self._heading_rad[step] = simulation.heading_rad
        self._actions[step] = wanted
        self._progress_m[step] = simulation.distance_m
        self._surroundings.measure(self._clearance_m[step], self._ahead_s[step])

    def after(self, step: int, met: npt.NDArray[np.bool_]) -> None:
        self._progress_m[step] = self._simulation.distance_m - self._progress_m[step]
        self._met[step] = met

    def track(self) -> Track:
        return Track(
            self._circumstances,
            self._lanes,
            self._x_m,
            self._y_m,
            self._heading_rad,
            self._progress_m,
            self._actions,
            self._met,
            self._clearance_m,
            self._ahead_s,
        )
