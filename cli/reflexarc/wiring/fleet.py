"""Several robots in one process, each on a thread of its own; what ends one ends all."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from reflexarc.wiring.bus_flags import Joining

_RobotResult = TypeVar("_RobotResult")

Ride = Callable[[Joining, int, Callable[[], bool]], _RobotResult | None]
"""(flags, number of the robot, asks whether to stop) → the result; None if it never drove."""


def drive_together(
    robots: Sequence[Joining], ride: Ride[_RobotResult], stop: Callable[[], bool]
) -> dict[str, _RobotResult]:
    """Drive all robots at once; return the result of each that drove, by name.

    Raises:
        Exception: what one of them raised; the others have been stopped.
    """
    if len(robots) == 1:  # the only one needs no thread
        result = ride(robots[0], 0, stop)
        return {} if result is None else {robots[0].robot: result}
    failed = threading.Event()

    def guarded(number: int) -> _RobotResult | None:
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
