"""A barrier for threads that run the same compiled loop: all wait until the last has arrived.

The last thread to arrive opens the barrier for the others and closes it behind them. A thread that
waits tests again and again, for the others are late by microseconds only; after a while it gives
its processor to other threads between two tests (`sched_yield`).
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.native.decorators import fused

_TESTS = 2000
"""Tests before the processor is given away: some ten microseconds."""

_sched_yield: Any = types.ExternalFunction("sched_yield", types.int32())


class Barrier(NamedTuple):
    """Two counters in memory that the threads share."""

    arrived: npt.NDArray[np.int64]
    """Threads that wait now: (1,)."""
    openings: npt.NDArray[np.int64]
    """How often the barrier has opened: (1,)."""


def new_barrier() -> Barrier:
    """A barrier at which no thread waits."""
    return Barrier(np.zeros(1, np.int64), np.zeros(1, np.int64))


@fused
def wait_for_all(barrier: Barrier, threads: int) -> None:
    """Return when all threads have called this; what each wrote before is then visible to all.

    Args:
        barrier: shared by the threads.
        threads: how many there are.
    """
    if threads == 1:
        return
    openings = _added(barrier.openings, 0)
    if _added(barrier.arrived, 1) == threads - 1:
        _added(barrier.arrived, -threads)
        _added(barrier.openings, 1)
        return
    tests = 0
    while _added(barrier.openings, 0) == openings:
        tests += 1
        if tests > _TESTS:
            _sched_yield()


def _add(_: Any, counter: Any, change: Any) -> Any:
    """Add to a counter (1,) in one atomic operation; returns the counter's former value."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        number = context.make_array(counter)(context, builder, args[0]).data
        return builder.atomic_rmw("add", number, args[1], "seq_cst")

    return types.int64(counter, types.int64), emit


_added: Any = intrinsic(_add)  # its stub says that a call returns nothing
