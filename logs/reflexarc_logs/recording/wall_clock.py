"""Notices when the wall clock is set during a recording, or the machine slept.

`log_time` does not follow: it is the monotonic clock plus the offset at the start. So a step is
written into the log, for whoever compares it with other records of the same hour.
"""

import time
from collections.abc import Callable

LEAST_STEP_NS = 50_000_000
"""Less than this is the clock being drawn to the right time, or the two readings being apart."""
_READINGS = 3


def offset_ns() -> int:
    """Wall clock minus monotonic clock, as well as a loaded machine lets it be read."""
    return min((_reading() for _ in range(_READINGS)), key=lambda reading: reading[0])[1]


class WallClock:
    """Compares the offset with the one that was said last.

    Args:
        offset: reads it.
    """

    def __init__(self, offset: Callable[[], int] = offset_ns) -> None:
        self._offset = offset
        self._first_ns = self._said_ns = offset()

    def look(self) -> str:
        """What happened to the wall clock since the last look, in words; empty if nothing did."""
        now_ns = self._offset()
        step_ns = now_ns - self._said_ns
        if abs(step_ns) < LEAST_STEP_NS:
            return ""
        self._said_ns = now_ns
        since_start_s = (now_ns - self._first_ns) * 1e-9
        return (
            f"the wall clock went {step_ns * 1e-9:+.3f} s against the monotonic one: it was set, "
            f"or the machine slept; {since_start_s:+.3f} s since the recording began; "
            "log times do not follow"
        )


def _reading() -> tuple[int, int]:
    """How long it took, and the offset."""
    before_ns = time.monotonic_ns()
    wall_ns = time.time_ns()
    after_ns = time.monotonic_ns()
    return after_ns - before_ns, wall_ns - (before_ns + after_ns) // 2
