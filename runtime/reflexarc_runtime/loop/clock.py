"""Clocks: the only code of the runtime that reads the time or sleeps."""

import time
from typing import Protocol


class Clock(Protocol):
    """A monotonic clock, and a way to sleep until a time on it."""

    def now_ns(self) -> int:
        """Nanoseconds since a fixed moment."""
        ...

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Return at or after the deadline; at once if it has passed."""
        ...


class MonotonicClock:
    """The machine's monotonic clock."""

    def now_ns(self) -> int:
        """See `Clock.now_ns`."""
        return time.monotonic_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        remaining_ns = deadline_ns - time.monotonic_ns()
        if remaining_ns > 0:
            time.sleep(remaining_ns * 1e-9)


class ManualClock:
    """A clock for tests: it advances only when a caller sleeps, at once, and may oversleep."""

    def __init__(self, now_ns: int = 0, oversleep_ns: int = 0) -> None:
        self.time_ns = now_ns
        self.oversleep_ns = oversleep_ns

    def now_ns(self) -> int:
        """See `Clock.now_ns`."""
        return self.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        if deadline_ns > self.time_ns:
            self.time_ns = deadline_ns + self.oversleep_ns


def wall_offset_ns() -> int:
    """What to add to the monotonic clock to get the wall clock, as of now."""
    return time.time_ns() - time.monotonic_ns()
