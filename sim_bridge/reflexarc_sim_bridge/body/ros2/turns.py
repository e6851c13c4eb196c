"""When a bridge to a robot speaks: at once when it has heard something, at the latest on time.

A robot that is told something only 50 times a second gets every command up to 20 ms late. So what
arrives wakes the bridge; its period counts from the last time that it spoke. Between two arrivals
that wake it lies a quarter of a period at least, so that a flood of commands is no flood of twists.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.messages.wire import Message

PATIENCE_NS = 50_000_000
"""How long a bridge waits at most before it looks whether it should end."""

_NS_A_SECOND = 1e9


class Mailbox(Protocol):
    """Where messages wait: see `Inbox`."""

    def take(self, timeout_s: float) -> Message | None:
        """The oldest message; None after the timeout."""
        ...

    def drain(self, now_ns: Callable[[], int]) -> tuple[tuple[Message, ...], int]:
        """All messages, oldest first, and the time."""
        ...


@dataclass(frozen=True, slots=True)
class Turn:
    """A moment at which the bridge may speak."""

    now_ns: int
    messages: tuple[Message, ...]
    is_due: bool
    """Whether it has to: a period has passed since it last did."""


class Turns:
    """Waits for the next turn.

    Args:
        rate_hz: how often the bridge speaks at least.
        clock: in whose time.
        inbox: where commands arrive.
    """

    def __init__(self, rate_hz: float, clock: Clock, inbox: Mailbox) -> None:
        self._period_ns = round(_NS_A_SECOND / rate_hz)
        self._clock = clock
        self._inbox = inbox
        self._spoke_ns = self._woken_ns = clock.now_ns() - self._period_ns

    @property
    def period_ns(self) -> int:
        """The longest time between two twists."""
        return self._period_ns

    def wait(self, should_stop: Callable[[], bool]) -> Turn | None:
        """Wait until something came or the period is over; None when asked to stop."""
        while not should_stop():
            left_ns = self._spoke_ns + self._period_ns - self._clock.now_ns()
            if left_ns <= 0:
                return self._turn(())
            first = self._inbox.take(min(left_ns, PATIENCE_NS) / _NS_A_SECOND)
            if first is not None:
                self._clock.sleep_until_ns(self._woken_ns + self._period_ns // 4)
                turn = self._turn((first,))
                self._woken_ns = turn.now_ns
                return turn
        return None

    def spoke(self, now_ns: int) -> None:
        """Note that the bridge has spoken."""
        self._spoke_ns = now_ns

    def rest(self, duration_ns: int) -> int:
        """Let a time pass, whatever arrives; the time after it."""
        self._clock.sleep_until_ns(self._clock.now_ns() + duration_ns)
        return self.now_ns()

    def now_ns(self) -> int:
        """The time."""
        return self._clock.now_ns()

    def _turn(self, first: tuple[Message, ...]) -> Turn:
        others, now_ns = self._inbox.drain(self._clock.now_ns)
        return Turn(now_ns, (*first, *others), now_ns >= self._spoke_ns + self._period_ns)
