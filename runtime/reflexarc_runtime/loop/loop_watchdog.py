"""The loop's watchdog: a thread that speaks in the loop's place while the loop is late.

The loop writes one integer at the beginning and at the end of each tick: the time by which it
should be heard again. The thread reads it four times within a budget. Past that time it sends the
safe command, again and again, says so on the bus, puts an `Overrun` into the loop's inbox (so that
it is in the log, and replays), withdraws the announcement that the runtime is alive, and asks the
backend to end its run. When the loop is back it is announced again.

After the watchdog has spoken, the loop's next command is a safe one: what a late tick decided was
for another moment, and is not sent.

What holds the interpreter's lock holds up this thread as well; `KernelTimer` is for that.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.kernel_timer import KernelTimer
from reflexarc_runtime.loop.outlets import Outlet
from reflexarc_runtime.messages.wire import Message

_NEVER_NS = 1 << 62
_SELDOM_NS = 50_000_000
"""Between two looks, and before a run can end, at most."""


class Presence(Protocol):
    """Tells the others that this node is alive."""

    def withdraw(self) -> None:
        """Let them see it as gone."""
        ...

    def renew(self) -> None:
        """Let them see it again."""
        ...


class Speaker(Protocol):
    """Says on the bus what the loop cannot say itself."""

    def stand(self, now_ns: int) -> None:
        """Send the safe command."""
        ...

    def tell(self, since_ns: int, late_ns: int, now_ns: int) -> Message:
        """Say how late the loop is; the message that its inbox is given."""
        ...


@dataclass(frozen=True)
class Budget:
    """How late a loop may be."""

    tick_ns: int
    """How long a tick may take, and how much later than its period the next one may begin."""
    period_ns: int
    process_s: float
    """How long the interpreter's lock may be held before the kernel ends the process."""


class LoopWatchdog:
    """A `Watch` with a clock of its own. A context manager: inside, its thread runs.

    Args:
        budget: how late the loop may be.
        now_ns: the clock of the loop.
        inbox: of the loop.
        speaker: what speaks in the loop's place, with publishers of its own.
        presence: the loop's announcement.
        end_decision: ends a decision that is going on, if it can be ended.
    """

    def __init__(
        self,
        budget: Budget,
        now_ns: Callable[[], int],
        inbox: Inbox,
        speaker: Speaker,
        presence: Presence,
        end_decision: Callable[[], None],
    ) -> None:
        self._budget = budget
        self._now_ns = now_ns
        self._inbox = inbox
        self._speaker = speaker
        self._presence = presence
        self._end_decision = end_decision
        self._timer = KernelTimer(budget.process_s)
        self._due_ns = _NEVER_NS
        self._spoke = False
        self._spoken_for_ns = 0
        self._turn = threading.Lock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)

    def __enter__(self) -> Self:
        self._timer.__enter__()
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join()
        self._timer.__exit__(kind, error, trace)

    @property
    def state(self) -> str:
        """See `Watch.state`."""
        return f"on, {self._budget.tick_ns / 1e6:g} ms"

    def begin(self, now_ns: int) -> None:
        """See `Watch.begin`."""
        self._due_ns = now_ns + self._budget.tick_ns
        self._timer.wind(now_ns)

    def rest(self, now_ns: int) -> None:
        """See `Watch.rest`."""
        self._due_ns = now_ns + self._budget.period_ns + self._budget.tick_ns

    def let_pass(self, outlet: Outlet, command: bytes, time_ns: int, is_safe: bool) -> bool:
        """See `Watch.let_pass`."""
        with self._turn:  # a command of the loop's never follows the watchdog's unseen
            if self._spoke and not is_safe:
                return False
            self._spoke = False
            outlet.put(command, time_ns)
            return True

    def look(self) -> None:
        """Look once whether the loop is late, and speak if it is."""
        due_ns, now_ns = self._due_ns, self._now_ns()
        if now_ns > due_ns:
            self._speak(due_ns, now_ns)
        elif self._spoken_for_ns:
            self._presence.renew()
            self._spoken_for_ns = 0

    def _watch(self) -> None:
        """Look, by a clock that nobody sets: an event's time-out may follow the wall clock."""
        clock, interval_ns = MonotonicClock(), min(self._budget.tick_ns // 4, _SELDOM_NS)
        while not self._ended.is_set():
            clock.sleep_until_ns(clock.now_ns() + interval_ns)
            if not self._ended.is_set():
                self.look()

    def _speak(self, due_ns: int, now_ns: int) -> None:
        with self._turn:
            if self._due_ns != due_ns:
                return  # it came back in between
            self._speaker.stand(now_ns)
            self._spoke = True
            if self._spoken_for_ns != due_ns:
                self._spoken_for_ns = due_ns
                since_ns = due_ns - self._budget.tick_ns
                self._inbox.put(self._speaker.tell(since_ns, now_ns - since_ns, now_ns))
        self._presence.withdraw()
        self._end_decision()
