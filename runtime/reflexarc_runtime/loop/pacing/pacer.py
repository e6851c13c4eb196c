"""A pacer decides when a tick begins, and with which messages."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.messages.wire import Message

PATIENCE_NS = 200_000_000
"""Interval at which a loop that waits for a far deadline checks whether it should end."""


@dataclass(frozen=True, slots=True)
class Wakeup:
    """The beginning of a tick."""

    slot: int
    deadline_ns: int
    """When the tick was due: lateness is counted from here."""
    wake_ns: int
    now_ns: int
    """The time of the tick: read once, after the inbox was drained."""
    messages: tuple[Message, ...]
    receive_ns: int
    """How long it took to drain the inbox."""
    missed: int = 0
    """Deadlines that passed before this tick without one."""


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


def came_near(clock: Clock, deadline_ns: int, should_stop: Callable[[], bool]) -> bool:
    """Sleep until a far deadline is near, asking now and then; False when asked to stop."""
    while (now_ns := clock.now_ns()) + PATIENCE_NS < deadline_ns and not should_stop():
        clock.before(deadline_ns).sleep_until_ns(now_ns + PATIENCE_NS)
    return not should_stop()
