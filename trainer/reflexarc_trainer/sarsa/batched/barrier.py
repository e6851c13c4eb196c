"""Where threads that run the same compiled loop wait for each other; compiled.

A gate is two numbers: how many have arrived, and how often it has opened. It opens when the last
one arrives. Whoever waits looks again and again, for others are late by microseconds; after a while
it leaves its processor to them between two looks.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.native.decorators import fused

Gate = npt.NDArray[np.int64]

_ARRIVED, _OPENED = 0, 1
_LOOKS = 2000
"""Before the processor is left to others: some ten microseconds."""

_sched_yield: Any = types.ExternalFunction("sched_yield", types.int32())


def new_gate() -> Gate:
    """A closed gate."""
    return np.zeros(2, np.int64)


@fused
def meet(gate: Gate, threads: int) -> None:
    """Go on when all threads have come here; what each wrote before is then seen by all."""
    if threads == 1:
        return
    opened = _added(gate, _OPENED, 0)
    if _added(gate, _ARRIVED, 1) == threads - 1:
        _added(gate, _ARRIVED, -threads)
        _added(gate, _OPENED, 1)
        return
    looks = 0
    while _added(gate, _OPENED, 0) == opened:
        looks += 1
        if looks > _LOOKS:
            _sched_yield()


def _add(_: Any, numbers: Any, index: Any, change: Any) -> Any:
    """Add to a number of an array in one piece, whatever other threads do; returns what it was."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        array = context.make_array(numbers)(context, builder, args[0])
        number = builder.gep(array.data, [args[1]])
        return builder.atomic_rmw("add", number, args[2], "seq_cst")

    return types.int64(numbers, types.int64, types.int64), emit


_added: Any = intrinsic(_add)  # its stub says that a call returns nothing
