"""One agent's step and the look that follows it, as one compiled call.

Called from Python, a compiled function is shown the type of every array that it is given and wraps
each of them, at every call: half a microsecond and more. So all that the step of one agent takes is
handed over once and held together (a `structref` of Numba: one reference-counted structure); the
call is given that alone.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numba
import numpy as np
import numpy.typing as npt
from numba.experimental import structref

from reflexarc_sim_bridge.native.decorators import compiled_allocating
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

REFUSED = -1
"""Outcome of an action that the contract does not have: nothing happened."""

_LOST = (
    "world: expected room for all obstacles near the agent, got a list that was full; "
    "`OneAgent.require_nothing_lost` says which"
)

Outcome: TypeAlias = tuple[int, float, float, float, int]
"""0, or 1 for a contact, or REFUSED; then x_m, y_m, distance_m, contacts."""


class OneHeldType(numba.types.StructRef):
    """Type of `OneHeld` in compiled code."""


_FIELDS = ["step", "world", "actions", "met", "states", "planes", "losses", "known"]


class OneHeld(structref.StructRefProxy):
    """A step and the world that it works on, by address, and what the agent does and meets."""

    kept: Any = None
    """Keeps the memory alive whose address is in `world`."""


_structref: Any = structref  # its functions have no types
_structref.register(OneHeldType)
_structref.define_proxy(OneHeld, OneHeldType, _FIELDS)


@compiled_allocating
def advance_one(held: Any, tasks: int, action: int) -> Outcome:
    """Let agent 0 do its tasks (sum of `step.MOVE` and `step.LOOK`), moving by an action."""
    if not 0 <= action < held.known:
        return REFUSED, 0.0, 0.0, 0.0, 0
    held.actions[0], held.met[0] = action, False
    step_world(held.step, held.world, held.actions, held.met, tasks, 0, 1)
    state = held.states[0]
    x_m = state.cell_x * CHUNK_M + state.x_m
    y_m = state.cell_y * held.planes[0].chunk_width_m + state.y_m
    for lost in held.losses:
        if lost > 0:
            raise OverflowError(_LOST)
    return int(held.met[0]), x_m, y_m, state.distance_m, state.contacts


@compiled_allocating
def hold(
    step: FunctionPointer,
    world: Struct,
    states: npt.NDArray[np.void],
    planes: npt.NDArray[np.void],
    losses: npt.NDArray[np.int64],
    known: int,
) -> Any:
    """Hand an agent over.

    Args:
        step: `step.advance`.
        world: a `step_pointer.Held`, to be put into `kept`.
        states: `AGENT_DTYPE`: (1,).
        planes: `PLANE_DTYPE`: (1,).
        losses: what the step counts as lost: see `Losses`.
        known: how many actions there are.
    """
    actions, met = np.zeros(1, np.int64), np.zeros(1, np.bool_)
    return OneHeld(step, world, actions, met, states, planes, losses, known)  # type: ignore[no-untyped-call]  # numba's


class OneAgent:
    """The only agent of a simulation, and the shortest way to it from Python."""

    def __init__(self, simulation: Simulation) -> None:
        step, self._world = simulation.held_step()
        world, _, agents = simulation.params
        known = len(simulation.contract.actions)
        losses = self._world.value.work.losses.counts
        held = hold(step, self._world, agents.state, world.planes, losses, known)
        held.kept = self._world  # who holds the function needs it, though `self` may be gone
        self.simulation = simulation
        self.stack = agents.stack[0]
        """What it sees: uint8 (frames · eyes · rays · channels,). Changes with every look."""
        advance = _compiled_for(held)
        self.step_and_sense: Callable[[int], Outcome] = partial(advance, held, MOVE + LOOK)
        """Moves it by an action of the contract, and lets it look.

        Raises an `OverflowError` where a list of obstacles was full; `require_nothing_lost` then
        says which.
        """
        self._sense = partial(advance, held, LOOK)

    def __reduce__(self) -> tuple[type["OneAgent"], tuple[Simulation]]:
        """A copy is bound to its own copy of the simulation."""
        return OneAgent, (self.simulation,)

    def sense(self) -> None:
        """Let it look, once before the first step."""
        try:
            self._sense(0)
        except OverflowError:
            self.require_nothing_lost()
            raise

    def require_nothing_lost(self) -> None:
        """Say which list it was where a step raised because one was full.

        Raises:
            WorldError: a list of obstacles was full, so that some could not be seen or met.
        """
        self.simulation.require_nothing_lost(self._world)


def _compiled_for(held: OneHeld) -> Callable[[OneHeld, int, int], Outcome]:
    """The function for these types: no dispatcher looks at them again, which takes 1 µs a call."""
    dispatcher: Any = advance_one
    typeof: Any = numba.typeof  # untyped
    types = (typeof(held), numba.types.int64, numba.types.int64)
    compiled_one: Callable[[OneHeld, int, int], Outcome] = dispatcher.compile(types)
    return compiled_one
