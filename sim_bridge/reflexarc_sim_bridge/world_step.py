"""The world's step by its address, for other compiled functions to call.

A compiled function that calls another by name takes it in and compiles it once more: a learner with
a world inside takes as long to compile as the world and the learner. Called by its address the
world is compiled once for all, and a learner is the same code for every world. What the step works
on lies at an address, too: a call with all its arrays by value would copy two hundred words.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.params import Params
from reflexarc_sim_bridge.reference import Reference, laid_out
from reflexarc_sim_bridge.workspace import Workspace, new_workspace


class Kept(NamedTuple):
    """What is put down."""

    params: Params
    work: Workspace
    motions: npt.NDArray[np.float64]


class Held:
    """Parameters, workspace and motions of a simulation, put down for one thread.

    It shares the simulation's memory; a copy of it is bound to a copy of the simulation.
    """

    def __init__(self, params: Params, motions: npt.NDArray[np.float64]) -> None:
        """Put them down.

        Args:
            params: the simulation's.
            motions: linear, lateral and angular speed of each action: (actions, 3).
        """
        self._kept = Kept(params, new_workspace(params), motions)
        self._memory = laid_out(self._kept)
        self.address = self._memory.ctypes.data
        """Where they lie."""

    def __reduce__(self) -> tuple[type["Held"], tuple[Params, npt.NDArray[np.float64]]]:
        return Held, (self._kept[0], self._kept[2])


def compiled_step(
    step: Any, params: Params, motions: npt.NDArray[np.float64], prepare: Callable[[], None]
) -> int:
    """Compile a step, unless that is done for such parameters; returns its address.

    Args:
        step: takes the address of what is held, actions (n,), room for contacts (n,), and three
            numbers: see `kernel.advance`.
        params: the simulation's.
        motions: as for `Held`.
        prepare: called before it is compiled or loaded.
    """
    typeof: Any = numba.typeof  # untyped
    form = step, _form(params), _form(motions)
    if form not in _addresses:
        prepare()
        world = Reference(typeof(Kept(params, new_workspace(params), motions)))
        signature = types.void(world, *_ARGUMENTS)
        step.compile(signature.args)
        result = step.get_compile_result(signature)
        _addresses[form] = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    return _addresses[form]


def types_held(params: Params) -> tuple[Reference, Reference]:
    """Types of the parameters and the workspace as a step has them."""
    typeof: Any = numba.typeof  # untyped
    return Reference(typeof(params)), Reference(typeof(new_workspace(params)))


def _form(value: Any) -> Any:
    """What the type of a value in compiled code depends on; to ask Numba for it takes 4 ms."""
    if isinstance(value, tuple):
        return tuple(map(_form, value))
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.c_contiguous, value.flags.writeable
    return type(value)


_addresses: dict[Any, int] = {}


_ARGUMENTS = types.int64[::1], types.boolean[::1], types.int64, types.int64, types.int64


def _call(
    _: Any, step: Any, held: Any, actions: Any, met: Any, tasks: Any, first: Any, end: Any
) -> Any:
    """Call a step: the addresses of both, then its arguments."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        kinds = (types.voidptr, *_ARGUMENTS)
        function = context.call_conv.get_function_type(types.none, kinds)
        step_at = builder.inttoptr(args[0], function.as_pointer())
        held_at = builder.inttoptr(args[1], context.get_value_type(types.voidptr))
        context.call_conv.call_function(builder, step_at, types.none, kinds, (held_at, *args[2:]))
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, *_ARGUMENTS), emit


call: Any = intrinsic(_call)  # its stub says that a call returns nothing
