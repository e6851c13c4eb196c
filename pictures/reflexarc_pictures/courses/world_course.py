"""Makes a course of a world: an agent drives through it."""

from collections.abc import Callable

import numpy as np

from reflexarc_pictures.courses.course import Course, Snapshot, eye_of
from reflexarc_pictures.log_pictures.decision_strips import BRIGHT
from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_sim_bridge.evaluation.cover_profile import right_side_m
from reflexarc_sim_bridge.evaluation.driving.drive import start
from reflexarc_sim_bridge.evaluation.driving.driver import Driver
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.world_scenery import WorldScenery
from reflexarc_sim_bridge.worlds.world import AfterContact, Edges, World, WorldSource

MOST_ACROSS_M = 40.0
"""Of a world that is wider, only a part around the agent is shown."""
AROUND_M = 5.0
"""How far behind and ahead of the path the walls of a corridor are looked at."""

_WALLS_M = 0.6
_WALL_PLACES = 100


def drive_in_world(
    source: WorldSource,
    contender: Contender,
    seed: int,
    duration_s: float,
    progress: Callable[[int, int], None] = lambda done, of: None,
    *,
    lane: int = 0,
    from_s: float = 0.0,
) -> Course:
    """Let an agent drive, with one decision in each step of the world.

    Args:
        source: the world; a family of worlds gives that of the seed.
        contender: who drives.
        seed: which of the world's variants, 0 to 2⁶⁴ − 1.
        duration_s: how long the course is, in the world's time.
        progress: called with the steps done and all steps.
        lane: which of the agents that share the world; they start apart.
        from_s: what is driven before the course begins.

    Raises:
        WorldError: the world does not support the contract.
    """
    world = source.drawn(seed)
    lanes = np.array([lane], np.uint64)
    simulation, driver = start(source, contender, np.array([seed], np.uint64), lanes)
    before, steps = round(from_s / world.dt_s), max(round(duration_s / world.dt_s), 1)
    simulation.sense()
    for step in range(before):
        _go_on(simulation, driver)
        simulation.sense()
        progress(step + 1, before + steps)
    snapshots = [_snapshot(simulation, world, None, met=False)]
    for step in range(steps):
        met = _go_on(simulation, driver)
        simulation.sense()
        snapshots.append(_snapshot(simulation, world, snapshots[-1], met))
        progress(before + step + 1, before + steps)
    return Course(
        title=f"{world.name}, seed {seed}",
        period_s=world.dt_s,
        snapshots=snapshots,
        eye=eye_of(contender.contract, simulation.bearings_rad),
        bright=BRIGHT[contender.contract.retina.shading],
        scenery=WorldScenery(simulation),
        radius_m=world.chassis.radius_m,
        strip_m=_strip_m(world, seed, snapshots),
        lateral_period_m=_period_m(world),
        begins_s=before * world.dt_s,
    )


def _go_on(simulation: Simulation, driver: Driver) -> bool:
    """One step; whether it ended in a contact."""
    met = simulation.step(driver.drive(simulation))
    driver.begin_anew(met)
    return bool(met[0])


def _snapshot(simulation: Simulation, world: World, last: Snapshot | None, met: bool) -> Snapshot:
    """The state of the agent now, with its newest retina."""
    y_m, period_m = float(simulation.y_m[0]), _period_m(world)
    if last is not None and period_m is not None:
        y_m += period_m * round((last.y_m - y_m) / period_m)  # the nearest of its repetitions
    return Snapshot(
        x_m=float(simulation.x_m[0]),
        y_m=y_m,
        heading_rad=float(simulation.heading_rad[0]),
        retina=simulation.stacks[0, -1].copy(),
        rays_m=_distances(simulation),
        contact=met,
        put=met and world.chassis.after_contact is not AfterContact.GHOST,
    )


def _distances(simulation: Simulation) -> Floats:
    return simulation.distances().astype(np.float64)


def _period_m(world: World) -> float | None:
    return world.width_m if world.edges is Edges.PERIODIC else None


def _strip_m(world: World, seed: int, snapshots: list[Snapshot]) -> tuple[float, float] | None:
    """Lowest and highest y of the world; of a corridor, of its walls along the path."""
    if world.corridor is not None:
        x_m = np.linspace(snapshots[0].x_m - AROUND_M, snapshots[-1].x_m + AROUND_M, _WALL_PLACES)
        right_m = right_side_m(world, seed, x_m)
        left_m = right_m + world.corridor.width_m
        return float(right_m.min()) - _WALLS_M, float(left_m.max()) + _WALLS_M
    is_bounded = world.edges is not Edges.UNBOUNDED and world.width_m <= MOST_ACROSS_M
    return (0.0, world.width_m) if is_bounded else None
