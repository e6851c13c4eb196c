"""The world's step by its address, for other compiled functions to call.

A learner with a world inside would take as long to compile as the world and the learner; so it is
the same code for every world (`by_address.py`). What the step works on lies at an address, too:
a call with all its arrays by value would copy two hundred words.
"""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.arrays.layout import Params
from reflexarc_sim_bridge.arrays.workspace import Parts, Workspace, new_workspace
from reflexarc_sim_bridge.native.function_pointers import emit_call
from reflexarc_sim_bridge.native.struct_pointers import Reference, laid_out


class Kept(NamedTuple):
    """What is put down."""

    params: Params
    work: Workspace
    motions: npt.NDArray[np.float64]


class Held:
    """Parameters, workspace and motions of a simulation, put down for one thread.

    It shares the simulation's memory, and cannot be copied: it is what lies at its address.
    """

    def __init__(self, params: Params, motions: npt.NDArray[np.float64], parts: Parts) -> None:
        """Put them down.

        Args:
            params: the simulation's.
            motions: linear, lateral and angular speed of each action: (actions, 3).
            parts: what the step calls.
        """
        self._kept = Kept(params, new_workspace(params, parts), motions)
        self._memory = laid_out(self._kept)
        self.address = self._memory.ctypes.data
        """Where they lie."""

    @property
    def work(self) -> Workspace:
        """What the step leaves behind."""
        return self._kept.work

    def __reduce__(self) -> Any:
        raise TypeError("Held: expected to stay in its place, as its address does; make a new one")


def types_held(params: Params) -> tuple[Reference, Reference]:
    """Types of the parameters and the workspace as a step has them."""
    typeof: Any = numba.typeof  # untyped
    return Reference(typeof(params)), Reference(typeof(new_workspace(params, Parts())))


def types_stepped(
    params: Params, motions: npt.NDArray[np.float64]
) -> tuple[Reference, *tuple[Any, ...]]:
    """Types of the arguments of a step: see `kernel.advance`."""
    typeof: Any = numba.typeof  # untyped
    kept = Kept(params, new_workspace(params, Parts()), motions)
    return Reference(typeof(kept)), *_ARGUMENTS


_ARGUMENTS = types.int64[::1], types.boolean[::1], types.int64, types.int64, types.int64


def _step_world(
    _: Any, step: Any, held: Any, actions: Any, met: Any, tasks: Any, first: Any, end: Any
) -> Any:
    """Let a world step: the addresses of both, then its arguments."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        held_at = builder.inttoptr(args[1], context.get_value_type(types.voidptr))
        kinds = (types.voidptr, *_ARGUMENTS)
        emit_call(context, builder, args[0], kinds, (held_at, *args[2:]))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, *_ARGUMENTS), emit


step_world: Any = intrinsic(_step_world)  # its stub says that a call returns nothing
