"""The world's step by its address, for other compiled functions to call.

A learner with a world inside would take as long to compile as the world and the learner; so it is
the same code for every world (`native/function_pointers.py`). What the step works on lies at an
address, too: a call with all its arrays by value would copy two hundred words.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from numba.core import types

from reflexarc_sim_bridge.arrays.layout import Params
from reflexarc_sim_bridge.arrays.workspace import Parts, Workspace, new_workspace
from reflexarc_sim_bridge.native.decorators import compiled_inline
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer, Signature, call
from reflexarc_sim_bridge.native.struct_pointers import Struct, StructPointer


class Held(NamedTuple):
    """What the step of one thread works on."""

    params: Params
    work: Workspace
    motions: npt.NDArray[np.float64]


STEP = Signature(
    "step", Held, types.int64[::1], types.boolean[::1], types.int64, types.int64, types.int64
)
"""What `step.advance` takes."""
COVER = Signature("cover", Held, types.float64[:, ::1], types.boolean[::1])
"""What `step.cover` takes."""
CAST = Signature("cast", Held)
"""What `step.cast` takes."""
SURVEY = Signature(
    "survey",
    Held,
    types.float64,
    types.float64,
    types.float32[::1],
    types.float32[::1],
    types.int64,
    types.int64,
)
"""What `step.survey` takes."""


NO_STEP, NOTHING_HELD = FunctionPointer(STEP), Struct.nowhere(Held)
"""For a call that compiles a learner, which then learns for no step."""


def new_held(params: Params, motions: npt.NDArray[np.float64], parts: Parts) -> Struct:
    """A `Held` in memory: parameters, scratch and motions of a simulation, for one thread.

    Args:
        params: the simulation's; its memory is shared.
        motions: linear, lateral and angular speed of each action: (actions, 3).
        parts: what the step calls.
    """
    return Struct(Held(params, new_workspace(params, parts), motions))


def type_of_held(params: Params, motions: npt.NDArray[np.float64]) -> StructPointer:
    """Type of a `Held` as the step has it."""
    return StructPointer(_typeof(Held(params, new_workspace(params, Parts()), motions)))


@compiled_inline
def step_world(
    step: FunctionPointer,
    held: Struct,
    actions: npt.NDArray[np.int64],
    met_out: npt.NDArray[np.bool_],
    tasks: int,
    first: int,
    end: int,
) -> None:
    """Let a world step, in compiled code: see `step.advance`."""
    call(step, (held, actions, met_out, tasks, first, end))


_typeof: Any = numba.typeof  # untyped
