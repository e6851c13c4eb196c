"""Pacers: when a tick happens, and with which messages.

- `RatePacer`: absolute deadlines on a clock. A slot that was missed is counted and skipped; there
  is never a burst of ticks to catch up.
- `LockstepPacer`: one tick for each sensor message, at its source time. It reads no clock and
  does not sleep: the same inputs give the same ticks on any machine under any load.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.topics import CONTROLS, topic_of
from reflexarc_runtime.messages.wire import Message, at_source_time

PATIENCE_NS = 200_000_000
"""Interval at which a loop that waits for a far deadline checks whether it should end."""

LOCKSTEP_PATIENCE_S = 0.05
"""Interval at which a waiting lockstep loop checks whether it should end."""


@dataclass(frozen=True, slots=True)
class Wakeup:
    """The beginning of a tick."""

    slot: int
    deadline_ns: int
    wake_ns: int
    now_ns: int
    """The time of the tick: read once, after the inbox was drained."""
    messages: tuple[Message, ...]
    receive_ns: int
    """How long it took to drain the inbox."""


class Pacer(Protocol):
    """Decides when the next tick begins."""

    def wait(self, should_stop: Callable[[], bool]) -> Wakeup | None:
        """Wait for the next tick; None when asked to stop while waiting."""
        ...

    def farewell(self) -> Wakeup:
        """The wake-up of a last tick, now, without waiting."""
        ...

    def now_ns(self) -> int:
        """The time from which durations of phases are computed."""
        ...


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
        self._slot = max(self._slot + 1, self._slot_due())
        deadline_ns = self._deadline_ns()
        while (now_ns := self._clock.now_ns()) + PATIENCE_NS < deadline_ns and not should_stop():
            self._clock.sleep_until_ns(now_ns + PATIENCE_NS)
        if should_stop():
            return None
        self._clock.sleep_until_ns(deadline_ns)
        return None if should_stop() else self.farewell()

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        wake_ns = self._clock.now_ns()
        messages, now_ns = self._inbox.drain(self._clock.now_ns)
        return Wakeup(self._slot, self._deadline_ns(), wake_ns, now_ns, messages, now_ns - wake_ns)

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return self._clock.now_ns()

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


class LockstepPacer:
    """One tick for each sensor message, at its source time.

    A stop or a reset makes no tick of its own, and no time: it comes with the next sensor message,
    so that the command of message n stays command n.
    """

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox
        self._controls: list[Message] = []
        self._slot = 0
        self._time_ns = 0

    def wait(self, should_stop: Callable[[], bool]) -> Wakeup | None:
        """See `Pacer.wait`."""
        while not should_stop():
            message = self._inbox.take(LOCKSTEP_PATIENCE_S)
            if message is None:
                continue
            if topic_of(message.key) in CONTROLS:
                self._controls.append(replace(message, received_ns=self._time_ns))
                continue
            arrived = at_source_time(message, self._time_ns)
            self._time_ns = arrived.received_ns
            controls, self._controls = self._controls, []
            return self._wake((*controls, arrived))
        return None

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        return self._wake(())

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return self._time_ns

    def _wake(self, messages: tuple[Message, ...]) -> Wakeup:
        self._slot += 1
        time_ns = self._time_ns
        return Wakeup(self._slot, time_ns, time_ns, time_ns, messages, 0)
