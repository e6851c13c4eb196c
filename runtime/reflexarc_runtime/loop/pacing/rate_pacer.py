"""Ticks at absolute deadlines on a clock, whatever arrives.

A slot that was missed is counted and skipped; there is never a burst of ticks to catch up.
"""

from collections.abc import Callable

from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.pacer import Wakeup, came_near


class RatePacer:
    """Absolute deadlines at a fixed rate."""

    def __init__(self, rate_hz: float, clock: Clock, inbox: Inbox) -> None:
        self._clock = clock
        self._inbox = inbox
        self._period_ns = round(1e9 / rate_hz)
        self._start_ns: int | None = None
        self._slot = 0

    def at(self, rate_hz: float) -> "RatePacer":
        """One that goes on from now at this rate, by the same clock and with the same inbox."""
        return RatePacer(rate_hz, self._clock, self._inbox)

    def wait(self, should_stop: Callable[[], bool]) -> Wakeup | None:
        """See `Pacer.wait`."""
        before = self._slot
        self._slot = max(before + 1, self._slot_due())
        deadline_ns = self._deadline_ns()
        if not came_near(self._clock, deadline_ns, should_stop):
            return None
        self._clock.sleep_until_ns(deadline_ns)
        return None if should_stop() else self._wake(self._slot - before - 1)

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        return self._wake(0)

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return self._clock.now_ns()

    def _wake(self, missed: int) -> Wakeup:
        wake_ns = self._clock.now_ns()
        messages, now_ns = self._inbox.drain(self._clock.now_ns)
        took_ns = now_ns - wake_ns
        return Wakeup(self._slot, self._deadline_ns(), wake_ns, now_ns, messages, took_ns, missed)

    def _slot_due(self) -> int:
        """The last slot whose deadline has come."""
        return (self._clock.now_ns() - self._origin_ns()) // self._period_ns

    def _deadline_ns(self) -> int:
        return self._origin_ns() + self._slot * self._period_ns

    def _origin_ns(self) -> int:
        """The moment of slot 0: when the loop first waited."""
        if self._start_ns is None:
            self._start_ns = self._clock.now_ns()
        return self._start_ns
