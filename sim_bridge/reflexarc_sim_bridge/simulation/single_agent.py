"""One agent's step and the look that follows it, as one compiled call."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numba

from reflexarc_sim_bridge.native.decorators import compiled_allocating
from reflexarc_sim_bridge.simulation.one_held import OneHeld, hold
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

REFUSED = -1
"""Outcome of an action that the contract does not have: nothing happened."""

Outcome: TypeAlias = tuple[int, float, float, float, int]
"""0, or 1 for a contact, or REFUSED; then x_m, y_m, distance_m, contacts."""


class OneAgent:
    """The only agent of a simulation, and the shortest way to it from Python."""

    def __init__(self, simulation: Simulation) -> None:
        step, self._world = simulation.held_step()
        world, _, agents = simulation.params
        known = len(simulation.contract.actions)
        held = hold(step, self._world.address, agents.state, world.planes, known)
        held.kept = self._world  # whoever can still call needs it, though `self` may be gone
        self.simulation = simulation
        self.stack = agents.stack[0]
        """What it sees: uint8 (frames · eyes · rays · channels,). Changes with every look."""
        advance = _compiled_for(held)
        self.step_and_sense: Callable[[int], Outcome] = partial(advance, held, MOVE + LOOK)
        """Moves it by an action of the contract, and lets it look."""
        self._sense = partial(advance, held, LOOK)

    def __reduce__(self) -> tuple[type["OneAgent"], tuple[Simulation]]:
        """A copy is bound to its own copy of the simulation."""
        return OneAgent, (self.simulation,)

    def sense(self) -> None:
        """Let it look, once before the first step."""
        self._sense(0)


@compiled_allocating
def advance_one(held: Any, tasks: int, action: int) -> Outcome:
    """Let agent 0 do its tasks (sum of `kernel.MOVE` and `LOOK`), moving by an action."""
    if not 0 <= action < held.known:
        return REFUSED, 0.0, 0.0, 0.0, 0
    held.actions[0], held.met[0] = action, False
    step_world(held.step, held.world, held.actions, held.met, tasks, 0, 1)
    state = held.states[0]
    x_m = state.cell_x * CHUNK_M + state.x_m
    y_m = state.cell_y * held.planes[0].chunk_width_m + state.y_m
    return int(held.met[0]), x_m, y_m, state.distance_m, state.contacts


def _compiled_for(held: OneHeld) -> Callable[[OneHeld, int, int], Outcome]:
    """The function for these types: no dispatcher looks at them again, which takes 1 µs a call."""
    dispatcher: Any = advance_one
    typeof: Any = numba.typeof  # untyped
    types = (typeof(held), numba.types.int64, numba.types.int64)
    compiled_one: Callable[[OneHeld, int, int], Outcome] = dispatcher.compile(types)
    return compiled_one
