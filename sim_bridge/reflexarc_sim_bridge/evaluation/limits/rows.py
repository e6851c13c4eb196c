"""The lattice on which a body that moves sideways can be: rows across a world, and what it meets.

At every step it goes v·Δt ahead, and a multiple of w·Δt to either side. So from one place it
reaches rows that are w·Δt apart; between those lie further rows, which a body reaches that began,
or was put after a contact, elsewhere. All of them are treated together: rows at most SPACING_M
apart.

Across a periodic world a whole number of steps must lead round. Where that is not so, a step is
taken for a little longer, by at most one part in the number of steps round: a body that moves so is
a little abler, and a limit remains one.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.setting import without_colours
from reflexarc_sim_bridge.simulation.lattice import MOST_MOTIONS, call_lattice
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.simulation.step_compilation import lattice_for
from reflexarc_sim_bridge.worlds.world import AfterContact, Chassis, Edges, Senses, World

SPACING_M = 0.02
"""Rows lie at most so far apart; the narrowest gap that matters is wider by far."""

_BLOCK = 512
"""Steps of which is known at a time what is met."""
_ASIDE = 0.381966
"""Place of the first row, in spacings: whatever is placed evenly lies on no row."""
_NEARLY = 1e-6
_SHORT_M = 0.01

Found = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Rows:
    """Rows across a world, and how the motions of a body lead from one to another."""

    rows_m: npt.NDArray[np.float64]
    """Lateral places: (rows,)."""
    ahead_m: float
    """By every step."""
    left_m: npt.NDArray[np.float64]
    """By each motion: (motions,)."""
    shifts: npt.NDArray[np.int64]
    """The same in rows: (motions,)."""
    wraps: bool
    """Whether the last row lies beside the first."""
    window: int
    """So many rows to either side are where a body goes on after a contact; 0: all."""


def rows_of(world: World, contract: PolicyContract, steps: int) -> Rows:
    """The rows of a body in a world.

    Args:
        world: with the body's step.
        contract: its actions.
        steps: how many it goes.

    Raises:
        UsageError: it does not move sideways at one speed ahead, by multiples of one speed aside.
    """
    multiples, aside_mps = multiples_of(contract)
    width_m, way_m = world.width_m, aside_mps * world.dt_s
    if world.edges is not Edges.UNBOUNDED:
        way_m = width_m / max(1, math.floor(width_m / way_m + _NEARLY)) if way_m else width_m
        if way_m * max(map(abs, multiples)) > width_m and aside_mps:
            raise UsageError(f"{world.name}: expected steps that are shorter than its width")
    between = max(1, math.ceil(way_m / SPACING_M - _NEARLY))
    spacing_m = way_m / between or SPACING_M
    return Rows(
        _rows_m(world, spacing_m, max(map(abs, multiples)) * way_m * steps),
        contract.actions[0].linear_mps * world.dt_s,
        np.array(multiples, np.float64) * (way_m if aside_mps else 0.0),
        np.array(multiples, np.int64) * between,
        wraps=world.edges is Edges.PERIODIC,
        window=0 if _is_held(world) else math.ceil(world.width_m / 2 / spacing_m),
    )


def bare(world: World) -> World:
    """A world and the size of a body in it, without how it looks and how well that body obeys.

    Raises:
        UsageError: its obstacles stop nobody.
    """
    if world.chassis.after_contact is AfterContact.GHOST:
        raise UsageError(f"{world.name}: expected a world whose obstacles stop a body, got ghosts")
    plain = Chassis(radius_m=world.chassis.radius_m)
    white = replace(without_colours(world), name="", description="", limits=BodyLimits())
    return replace(white, senses=Senses(), scanner=None, chassis=plain)


class Lookout:
    """What a body would meet in one world.

    Args:
        world: a bare one.
        seed: which of its variants.
        ahead_m: how far each step of the body goes ahead.
        left_m: how far each of its motions goes to the left: (motions,).
    """

    def __init__(self, world: World, seed: int, ahead_m: float, left_m: Floats) -> None:
        # Motions as they are here, and an eye so short that what is near is what can be met.
        ahead_mps, left_mps = ahead_m / world.dt_s, left_m / world.dt_s
        actions = tuple(Action(str(k), ahead_mps, y) for k, y in enumerate(left_mps.tolist()))
        short = RetinaSpec(rays=1, range_m=_SHORT_M)
        contract = PolicyContract(retina=short, actions=actions)
        self._motions = ahead_m, left_m
        self._simulation = Simulation(world, contract, np.array([seed], np.uint64))
        self._held = self._simulation.held_step()[1]
        self._look = lattice_for(self._simulation.params, motions_of(contract))

    def look(self, start_m: float, rows_m: Floats, first: int, steps: int) -> Found:
        """What `lattice.look_along` says of some steps, the first of which begins at a place."""
        found = np.empty((steps, len(rows_m)), np.uint8)
        ahead_m, left_m = self._motions
        call_lattice(self._look, self._held, start_m, rows_m, ahead_m, left_m, first, found)
        self._simulation.require_nothing_lost(self._held)
        return found


def blocks_back(world: World, seed: int, rows: Rows, steps: int) -> Iterator[tuple[int, Found]]:
    """What is met on a lattice, from the last steps to the first.

    Args:
        world: a bare one.
        seed: which of its variants.
        rows: a body's lattice.
        steps: how many.

    Yields:
        The number of the first step of a block, and what `lattice.look_along` says of it.
    """
    lookout = Lookout(world, seed, rows.ahead_m, rows.left_m)
    for first in reversed(range(0, steps, _BLOCK)):
        length = min(_BLOCK, steps - first)
        yield first, lookout.look(first * rows.ahead_m, rows.rows_m, first, length)


def multiples_of(contract: PolicyContract) -> tuple[list[int], float]:
    """By how many times which speed each action goes to the left.

    Raises:
        UsageError: see `rows_of`.
    """
    actions = contract.actions
    ahead_mps = {action.linear_mps for action in actions}
    if len(ahead_mps) != 1 or ahead_mps.pop() <= 0.0 or any(a.angular_radps for a in actions):
        raise UsageError("limits: expected actions that go ahead at one speed, and do not turn")
    if len(actions) > MOST_MOTIONS:
        raise UsageError(f"limits: expected at most {MOST_MOTIONS} actions, got {len(actions)}")
    speeds = [action.lateral_mps for action in actions]
    least = min((abs(speed) for speed in speeds if speed), default=0.0)
    multiples = [round(speed / least) if least else 0 for speed in speeds]
    if any(abs(m * least - s) > _NEARLY * least for m, s in zip(multiples, speeds, strict=True)):
        raise UsageError(f"limits: expected multiples of one sideways speed, got {speeds}")
    return multiples, least


def _is_held(world: World) -> bool:
    """Whether a body can leave a strip of the world for good."""
    return world.edges is not Edges.UNBOUNDED or world.corridor is not None


def _rows_m(world: World, spacing_m: float, strays_m: float) -> Floats:
    if world.edges is Edges.OPEN:  # motions end at its sides exactly
        return np.linspace(0.0, world.width_m, round(world.width_m / spacing_m) + 1)
    if world.edges is Edges.PERIODIC:
        return _places_m(0, round(world.width_m / spacing_m), spacing_m)
    half_m = world.width_m / 2 + strays_m
    if world.corridor is not None:
        half_m = world.corridor.meander_m + world.corridor.width_m / 2
    count = math.ceil(half_m / spacing_m)
    return _places_m(-count, count + 1, spacing_m)


def _places_m(first: int, end: int, spacing_m: float) -> Floats:
    places_m: Floats = (np.arange(first, end, dtype=np.float64) + _ASIDE) * spacing_m
    return places_m
