"""Clocks: the only code of the runtime that reads the time or sleeps."""

import heapq
import time
from collections.abc import Callable
from itertools import count
from typing import Protocol

from reflexarc_runtime.loop.bell import Bell


class Clock(Protocol):
    """A monotonic clock, and ways to sleep until a time on it."""

    def now_ns(self) -> int:
        """Nanoseconds since a fixed moment."""
        ...

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Return at or after the deadline; at once if it has passed."""
        ...

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        """Return when the bell is rung, or else like `sleep_until_ns`; whether it was rung."""
        ...

    def before(self, deadline_ns: int) -> "Clock":
        """The same one for waits that end before a deadline: only that is worth a processor."""
        ...


class MonotonicClock:
    """The machine's monotonic clock.

    Args:
        spin_ns: so long before a deadline it stops sleeping and looks at the time instead, again
            and again: that takes a processor, and misses the deadline by less.
        deadline_ns: the one deadline that counts; None: the end of each wait.
    """

    def __init__(self, spin_ns: int = 0, deadline_ns: int | None = None) -> None:
        self._spin_ns, self._deadline_ns = spin_ns, deadline_ns

    def now_ns(self) -> int:
        """See `Clock.now_ns`."""
        return time.monotonic_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        asleep_s = self._asleep_s(deadline_ns)
        if asleep_s > 0.0:
            time.sleep(asleep_s)
        if self._spin_ns:
            while time.monotonic_ns() < deadline_ns:
                time.sleep(0)  # gives the interpreter's lock away: messages come in meanwhile

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        """See `Clock.wait_until_ns`."""
        is_rung = bell.heard(self._asleep_s(deadline_ns))
        while self._spin_ns and not is_rung and time.monotonic_ns() < deadline_ns:
            time.sleep(0)
            is_rung = bell.heard(0.0)
        return is_rung

    def before(self, deadline_ns: int) -> "MonotonicClock":
        """See `Clock.before`; it never sleeps in the time in which it would spin up to that."""
        return MonotonicClock(self._spin_ns, deadline_ns) if self._spin_ns else self

    def _asleep_s(self, until_ns: int) -> float:
        """How long to sleep before it looks at the time."""
        deadline_ns = until_ns if self._deadline_ns is None else self._deadline_ns
        end_ns = min(until_ns, deadline_ns - self._spin_ns)
        return (end_ns - time.monotonic_ns()) * 1e-9


class ManualClock:
    """A clock for tests: it advances only when a caller sleeps, at once, and may oversleep.

    What is to happen at a time can be said beforehand: `at_ns`. It happens when the clock comes
    there, and then the clock shows that time.
    """

    def __init__(self, now_ns: int = 0, oversleep_ns: int = 0) -> None:
        self.time_ns = now_ns
        self.oversleep_ns = oversleep_ns
        self._to_come: list[tuple[int, int, Callable[[], object]]] = []
        self._order = count()

    def at_ns(self, time_ns: int, act: Callable[[], object]) -> None:
        """Do something when the clock comes to a time: the first said first, at one time."""
        heapq.heappush(self._to_come, (time_ns, next(self._order), act))

    def advance_to_ns(self, time_ns: int) -> None:
        """Let time pass: work that takes long, a machine that stands still."""
        while self._to_come and self._to_come[0][0] <= time_ns:
            self._happen()
        self.time_ns = max(self.time_ns, time_ns)

    def now_ns(self) -> int:
        """See `Clock.now_ns`."""
        return self.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        if deadline_ns > self.time_ns:
            self.advance_to_ns(deadline_ns + self.oversleep_ns)

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        """See `Clock.wait_until_ns`; it oversleeps after a ring as well."""
        while not bell.heard(0.0):
            if not self._to_come or self._to_come[0][0] > deadline_ns:
                self.sleep_until_ns(deadline_ns)
                return False
            self._happen()
        self.advance_to_ns(self.time_ns + self.oversleep_ns)
        return True

    def before(self, deadline_ns: int) -> "ManualClock":
        """See `Clock.before`."""
        return self

    def _happen(self) -> None:
        time_ns, _, act = heapq.heappop(self._to_come)
        self.time_ns = max(self.time_ns, time_ns)
        act()


def wall_offset_ns() -> int:
    """What to add to the monotonic clock to get the wall clock, as of now."""
    return time.time_ns() - time.monotonic_ns()
