"""One agent's step and the look that follows it, as one compiled call."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numba

from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.held import Held, hold
from reflexarc_sim_bridge.kernel import sense_agent, step_agent
from reflexarc_sim_bridge.layers import CHUNK_M
from reflexarc_sim_bridge.simulation import Simulation

REFUSED = -1
"""Outcome of an action that the contract does not have: nothing happened."""

Outcome: TypeAlias = tuple[int, float, float, float, int]
"""0, or 1 for a contact, or REFUSED; then x_m, y_m, distance_m, contacts."""


class OneAgent:
    """The only agent of a simulation, and the shortest way to it from Python."""

    def __init__(self, simulation: Simulation) -> None:
        held = hold(simulation)
        self.simulation = simulation
        self.stack = simulation.params.agents.stack[0]
        """What it sees: uint8 (frames · eyes · rays · channels,). Changes with every look."""
        self.step_and_sense: Callable[[int], Outcome] = partial(_compiled_for(held), held, True)
        """Moves it by an action of the contract, and lets it look."""
        self._sense = partial(_compiled_for(held), held, False)

    def __reduce__(self) -> tuple[type["OneAgent"], tuple[Simulation]]:
        """A copy is bound to its own copy of the simulation."""
        return OneAgent, (self.simulation,)

    def sense(self) -> None:
        """Let it look, once before the first step."""
        self._sense(0)


@compiled_allocating
def step_and_sense_agent(held: Any, moves: bool, action: int) -> Outcome:
    """Move agent 0 by an action of the contract, unless it only looks; then look.

    One function for both, as each that holds a whole step takes its time to compile.
    """
    if not 0 <= action < len(held.motions):
        return REFUSED, 0.0, 0.0, 0.0, 0
    params, work, motion = held.params, held.work, held.motions[action]
    met = moves and step_agent(params, work, 0, motion[0], motion[1], motion[2])
    sense_agent(params, work, 0)
    state = params.agents.state[0]
    x_m = state.cell_x * CHUNK_M + state.x_m
    y_m = state.cell_y * params.world.planes[state.world].chunk_width_m + state.y_m
    return int(met), x_m, y_m, state.distance_m, state.contacts


def _compiled_for(held: Held) -> Callable[[Held, bool, int], Outcome]:
    """The function for these types: no dispatcher looks at them again, which takes 1 µs a call."""
    dispatcher: Any = step_and_sense_agent
    types: Any = (numba.typeof(held), numba.types.boolean, numba.types.int64)  # type: ignore[no-untyped-call]  # numba's
    call: Callable[[Held, bool, int], Outcome] = dispatcher.compile(types)
    return call
