"""The compiled step of agents in their worlds: sense, move, and keep near what can be met.

`advance` treats a range of agents. Whatever an agent does touches its own rows only, so the bits
are the same on any number of threads.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.compile_ahead import compiled_meanwhile
from reflexarc_sim_bridge.compile_cache import is_kept
from reflexarc_sim_bridge.compiled import (
    compiled,
    compiled_called,
    compiled_free,
)
from reflexarc_sim_bridge.foresight import foresee
from reflexarc_sim_bridge.motion import step_agent
from reflexarc_sim_bridge.near import forget_near, keep_near
from reflexarc_sim_bridge.overlap import touches
from reflexarc_sim_bridge.params import Params
from reflexarc_sim_bridge.places import go_to_free_place, set_place
from reflexarc_sim_bridge.second_process import has_room
from reflexarc_sim_bridge.senses import sense_agent
from reflexarc_sim_bridge.vision import look
from reflexarc_sim_bridge.workspace import Workspace
from reflexarc_sim_bridge.world_step import call, compiled_step, types_held

__all__ = [
    "LOOK",
    "MOVE",
    "PLACE",
    "advance",
    "call_step",
    "cast",
    "cover",
    "step_of",
]

PLACE, MOVE, LOOK = 1, 2, 4
"""What `advance` does, in this order; their sum for several."""


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

    One function for all of it, as each that holds a whole step takes its time to compile; called
    by its address (`step_of`).

    Args:
        held: address of the simulation's parameters, workspace and motions: a `Held`.
        actions: one an agent: (n,).
        met_out: filled where they move: which met an obstacle: (n,).
        tasks: sum of PLACE, MOVE and LOOK.
        first: first agent.
        end: agent behind the last.
    """
    params, work, motions = held.params, held.work, held.motions
    for i in range(first, end):
        if i + 1 < end:
            foresee(params, i + 1, 0)
        if tasks & PLACE:
            forget_near(params.agents, i)
            go_to_free_place(params, work, i)
        if tasks & MOVE:
            motion = motions[actions[i]]
            met_out[i] = step_agent(params, work, i, motion[0], motion[1], motion[2])
        if i + 1 < end:
            foresee(params, i + 1, 1)
        if tasks & LOOK:
            sense_agent(params, work, i)


def step_of(params: Params, motions: npt.NDArray[np.float64]) -> int:
    """Address of `advance`, compiled for such parameters and motions."""
    return compiled_step(advance, params, motions, lambda: _compile_halves(params))


def _compile_halves(params: Params) -> None:
    """Compile the two large parts of `advance` side by side, unless it is in the cache."""
    if has_room() and not is_kept("kernel.advance"):
        types = (*types_held(params), numba.int64)
        with compiled_meanwhile(sense_agent, types):
            go_to_free_place.compile(types)  # type: ignore[attr-defined]  # numba's


@compiled_free
def call_step(
    step: int,
    held: int,
    actions: npt.NDArray[np.int64],
    met_out: npt.NDArray[np.bool_],
    tasks: int,
    first: int,
    end: int,
) -> None:
    """Call `advance` from Python; `step` is its address, `held` that of a `Held`."""
    call(step, held, actions, met_out, tasks, first, end)


@compiled
def cover(
    params: Params,
    work: Workspace,
    places_m: npt.NDArray[np.float64],
    found_out: npt.NDArray[np.bool_],
) -> None:
    """Whether agent 0 would cover or touch an obstacle: at (x, y): (n, 2); filled: (n,)."""
    state = params.agents.state[0]
    forget_near(params.agents, 0)
    for k in range(len(places_m)):
        set_place(params.world.planes[state.world], state, 0, places_m[k, 0], 0, places_m[k, 1])
        keep_near(params, work, 0)
        found_out[k] = touches(params, 0)


@compiled
def cast(params: Params, work: Workspace) -> None:
    """What the sub-rays of agent 0's first eye meet is in `work.distance_m` (subrays,)."""
    look(params, work, 0, 0)
