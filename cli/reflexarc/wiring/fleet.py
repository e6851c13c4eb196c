"""Several robots in one process, each on a thread of its own; what ends one ends all."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from reflexarc.wiring.bus_flags import Joining

_Result = TypeVar("_Result")

Ride = Callable[[Joining, int, Callable[[], bool]], _Result | None]
"""(who, its number, asks whether to stop) → what became of it, None if nothing did."""


def drive_together(
    robots: Sequence[Joining], ride: Ride[_Result], stop: Callable[[], bool]
) -> dict[str, _Result]:
    """Let every robot ride; returns what became of each that came to drive, by name.

    Raises:
        Exception: what one of them raised; the others have been stopped.
    """
    if len(robots) == 1:  # the only one needs no thread
        result = ride(robots[0], 0, stop)
        return {} if result is None else {robots[0].robot: result}
    failed = threading.Event()

    def guarded(number: int) -> _Result | None:
        try:
            return ride(robots[number], number, lambda: stop() or failed.is_set())
        except BaseException:
            failed.set()
            raise

    with ThreadPoolExecutor(len(robots)) as pool:
        results = list(pool.map(guarded, range(len(robots))))
    return {
        robot.robot: result
        for robot, result in zip(robots, results, strict=True)
        if result is not None
    }
