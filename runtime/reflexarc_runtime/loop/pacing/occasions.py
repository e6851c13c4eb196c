"""When a tick is rehearsed: once in good time before it begins, and once again shortly before.

What is done then, and why, says `rehearsal`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.loop.bell import Bell
from reflexarc_runtime.loop.clock import Clock

LONGEST_NS = 1_000_000
"""What takes longer is held up by its arithmetic, and not by cold caches."""
TRIED_AGAIN_AFTER = 100
"""Deadlines: once it may have taken long by chance."""


class Rehearses(Protocol):
    """Does the last tick again."""

    @property
    def tick_ns(self) -> int | None:
        """How long that tick took; None: there is none yet."""
        ...

    def __call__(self) -> None:
        """Do it."""
        ...


@dataclass
class Occasion:
    """One time before each tick at which it is rehearsed.

    Args:
        margin_ns: how long before the tick it should have ended.
        most_share: of the whole sleep that it may take; a large network is not computed twice.
    """

    margin_ns: int
    most_share: float
    took_ns: int | None = None
    """Last time; None before the first."""
    left_out: int = 0
    """How often since, as it took too long."""

    def begin_ns(self, due_ns: int, now_ns: int, sleep_ns: int, tick_ns: int) -> int | None:
        """When it should begin; None if there is no time for it.

        Where it takes as long as the last tick, and not as the last time, it still ends in time:
        another policy may have taken over.

        Args:
            due_ns: when the next tick begins.
            now_ns: now.
            sleep_ns: how long before the tick the loop began to sleep.
            tick_ns: how long the last tick took.
        """
        if self._is_long(tick_ns, min(LONGEST_NS, self.most_share * sleep_ns)):
            return None
        takes_ns = tick_ns if self.took_ns is None else self.took_ns
        begin_ns = due_ns - max(self.margin_ns + takes_ns, tick_ns)
        return begin_ns if begin_ns > now_ns else None

    def _is_long(self, tick_ns: int, most_ns: float) -> bool:
        """Whether it is left out; if it took long itself, for so many deadlines."""
        if tick_ns > most_ns:
            return True
        is_long = self.took_ns is not None and self.took_ns > most_ns
        self.left_out = self.left_out + 1 if is_long and self.left_out < TRIED_AGAIN_AFTER else 0
        return self.left_out > 0


class Occasions:
    """Rehearses once in good time before a tick, and once shortly before.

    Args:
        now_ns: reads the time.
        rehearse: what is done.
    """

    def __init__(self, now_ns: Callable[[], int], rehearse: Rehearses) -> None:
        self._now_ns, self._rehearse = now_ns, rehearse
        self._occasions = Occasion(300_000, 0.03), Occasion(80_000, 0.3)

    def before(self, due_ns: int, is_called: Callable[[int], bool]) -> bool:
        """Rehearse before a tick, unless the loop is called meanwhile; whether it was.

        Args:
            due_ns: when it begins.
            is_called: sleeps until a time, or until a tick must begin at once; whether it must.
        """
        tick_ns, sleep_ns = self._rehearse.tick_ns, due_ns - self._now_ns()
        if tick_ns is None:
            return False
        for occasion in self._occasions:
            begin_ns = occasion.begin_ns(due_ns, self._now_ns(), sleep_ns, tick_ns)
            if begin_ns is None:
                continue
            if is_called(begin_ns):
                return True
            began_ns = self._now_ns()
            if began_ns - begin_ns < occasion.margin_ns // 2:  # else it overslept: a tick is near
                self._rehearse()
                occasion.took_ns = self._now_ns() - began_ns
        return False


class RehearsingClock:
    """A clock that rehearses before it returns from a sleep.

    Args:
        clock: by which it sleeps.
        rehearse: what it does.
    """

    def __init__(self, clock: Clock, rehearse: Rehearses) -> None:
        self._clock, self.before = clock, clock.before
        self.now_ns = clock.now_ns  # asked at every phase of a tick
        self._occasions = Occasions(clock.now_ns, rehearse)

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        early = self._clock.before(deadline_ns)

        def is_called(until_ns: int) -> bool:
            early.sleep_until_ns(until_ns)
            return False

        self._occasions.before(deadline_ns, is_called)
        self._clock.sleep_until_ns(deadline_ns)

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        """See `Clock.wait_until_ns`; nothing is rehearsed, as a ring may come at any time."""
        return self._clock.wait_until_ns(deadline_ns, bell)
