"""Work on all agents at once: compiled functions over ranges of agents, one range a thread.

The compiled functions let go of Python's lock while they run. Which thread treats an agent, and how
many there are, does not show in the bits: an agent's work touches its own rows only.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import lru_cache
from itertools import pairwise

FEWEST_AGENTS = 64
"""Fewer a thread are not worth one."""

_settings = {"threads": 0}


def thread_count() -> int:
    """How many threads share the work: as many as there are processors, unless told otherwise."""
    return _settings["threads"] or len(os.sched_getaffinity(0))


def set_thread_count(threads: int) -> None:
    """Share the work among so many threads; 0 for as many as there are processors."""
    _settings["threads"] = threads


def shared(work: Callable[[int, int], object], agents: int) -> None:
    """Call `work(first, end)` for ranges that make up all agents, at the same time.

    Raises:
        Exception: whatever one of the calls raised.
    """
    _call_all(work, _bounds(agents, min(thread_count(), max(1, agents // FEWEST_AGENTS))))


def together(work: Callable[[int, int], object], parts: int) -> None:
    """The same for parts that may wait for each other: all calls are sure to run at once.

    Ctrl-C waits until they are done.
    """
    bounds = _bounds(parts, min(thread_count(), parts))
    if len(bounds) == 2:
        work(0, parts)
        return
    # An interrupt reaches the main thread only: it must not keep one of the calls from being made.
    call = _conductor().submit(_call_all, work, bounds)
    try:
        call.result()
    except BaseException:
        wait([call])
        if (raised := call.exception()) is not None:  # it counts more than an interrupt
            raise raised from None
        raise


def _bounds(parts: int, threads: int) -> list[int]:
    return [parts * k // threads for k in range(threads + 1)]


def _call_all(work: Callable[[int, int], object], bounds: list[int]) -> None:
    calls = [_pool(len(bounds) - 1).submit(work, *pair) for pair in pairwise(bounds[1:])]
    try:
        work(bounds[0], bounds[1])
    finally:  # nobody writes to the agents' rows any more when this returns, however it does
        wait(calls)
    for call in calls:
        call.result()


@lru_cache(maxsize=1)
def _conductor() -> ThreadPoolExecutor:
    """One thread: two groups of calls that wait for each other would each take half a pool."""
    return ThreadPoolExecutor(1, thread_name_prefix="reflexarc-together")


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(1, threads - 1), thread_name_prefix="reflexarc-world")
