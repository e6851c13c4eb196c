"""The compiled step of agents in their worlds: each moves, then looks.

`advance` treats a range of agents. Whatever an agent does touches its own rows only, so the bits
are the same on any number of threads.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.motion.chassis import step_agent
from reflexarc_sim_bridge.motion.overlap import TOUCHING_M, touches
from reflexarc_sim_bridge.motion.placing import set_place
from reflexarc_sim_bridge.motion.room import free_s, room_m
from reflexarc_sim_bridge.native.decorators import compiled_called, compiled_free
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer, call
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.obstacles.gathering import keep_near
from reflexarc_sim_bridge.obstacles.near_lists import forget_near
from reflexarc_sim_bridge.simulation.prefetch import foresee
from reflexarc_sim_bridge.simulation.step_pointer import STEP, step_world
from reflexarc_sim_bridge.vision.ray_casting import look

__all__ = [
    "LOOK",
    "MOVE",
    "PLACE",
    "advance",
    "call_cast",
    "call_cover",
    "call_step",
    "call_survey",
]

PLACE, MOVE, LOOK = 1, 2, 4
"""Tasks of `advance`, which are done in this order; a sum stands for several."""


@compiled_called
def advance(
    held: Any,
    actions: npt.NDArray[np.int64],
    met_out: npt.NDArray[np.bool_],
    tasks: int,
    first: int,
    end: int,
) -> None:
    """Let the agents from `first` to `end` take their places, move and look.

    Args:
        held: the simulation's parameters, scratch and motions: a `Held`.
        actions: one an agent: (n,).
        met_out: filled where they move: which met an obstacle: (n,).
        tasks: sum of PLACE, MOVE and LOOK.
        first: first agent.
        end: agent behind the last.
    """
    params, work, motions, parts = held.params, held.work, held.motions, held.work.parts
    for i in range(first, end):
        if i + 1 < end:
            foresee(params, i + 1, 0)
        if tasks & PLACE:
            forget_near(params.agents, i)
            call(parts.put, (params, work, i))
        if tasks & MOVE:
            motion = motions[actions[i]]
            met_out[i] = step_agent(params, work, i, motion[0], motion[1], motion[2])
        if i + 1 < end:
            foresee(params, i + 1, 1)
        if tasks & LOOK:
            call(parts.look, (params, work, i))


@compiled_called
def cover(held: Any, places_m: npt.NDArray[np.float64], found_out: npt.NDArray[np.bool_]) -> None:
    """Whether agent 0 would cover or touch an obstacle: at (x, y): (n, 2); filled: (n,)."""
    params = held.params
    state = params.agents.state[0]
    forget_near(params.agents, 0)
    for k in range(len(places_m)):
        set_place(params.world.planes[state.world], state, 0, places_m[k, 0], 0, places_m[k, 1])
        keep_near(params, held.work, 0)
        found_out[k] = touches(params, 0)


@compiled_called
def cast(held: Any) -> None:
    """What the sub-rays of agent 0's first eye meet is in `work.distance_m` (subrays,)."""
    look(held.params, held.work, 0, 0)


@compiled_called
def survey(
    held: Any,
    forward_mps: float,
    range_m: float,
    clearance_m: npt.NDArray[np.float32],
    ahead_s: npt.NDArray[np.float32],
    first: int,
    end: int,
) -> None:
    """How much room the agents from `first` to `end` have: see `AgentSurroundings.measure`.

    Args:
        held: a `Held`.
        forward_mps: how fast they would go straight on.
        range_m: nothing farther from their middle counts.
        clearance_m: filled: (n,).
        ahead_s: filled: (n,).
        first: first agent.
        end: agent behind the last.
    """
    for i in range(first, end):
        clearance_m[i] = room_m(held.params, i, range_m)
        ahead_s[i] = 0.0
        if clearance_m[i] > TOUCHING_M:
            ahead_s[i] = free_s(held.params, held.work, i, forward_mps, range_m)


@compiled_free
def call_step(
    step: FunctionPointer,
    held: Struct,
    actions: npt.NDArray[np.int64],
    met_out: npt.NDArray[np.bool_],
    tasks: int,
    first: int,
    end: int,
) -> None:
    """Call `advance` from Python; `held` is a `Held`."""
    step_world(step, held, actions, met_out, tasks, first, end)


def direct_call_step() -> Callable[..., None]:
    """`call_step`, compiled: no dispatcher looks at the types of what it is given.

    That would take 5 µs a call, half of what it takes four agents to move and look.
    """
    dispatcher: Any = call_step
    compiled_call: Callable[..., None] = dispatcher.compile((STEP, *STEP.arguments))
    return compiled_call


@compiled_free
def call_cover(
    cover_at: FunctionPointer,
    held: Struct,
    places_m: npt.NDArray[np.float64],
    found_out: npt.NDArray[np.bool_],
) -> None:
    """Call `cover` from Python; `held` is a `Held`."""
    call(cover_at, (held, places_m, found_out))


@compiled_free
def call_cast(cast_at: FunctionPointer, held: Struct) -> None:
    """Call `cast` from Python; `held` is a `Held`."""
    call(cast_at, (held,))


@compiled_free
def call_survey(
    survey_at: FunctionPointer,
    held: Struct,
    forward_mps: float,
    range_m: float,
    clearance_m: npt.NDArray[np.float32],
    ahead_s: npt.NDArray[np.float32],
    first: int,
    end: int,
) -> None:
    """Call `survey` from Python; `held` is a `Held`."""
    call(survey_at, (held, forward_mps, range_m, clearance_m, ahead_s, first, end))
