"""Does the last tick again just before the next one, and throws it away: the caches are warm then.

Between two ticks the processor's caches fill with what others do, so that at 50 Hz a decision takes
several times as long as in a tight loop. `controller.step` is pure: doing it once more changes
nothing, and what the next tick needs lies near when its input comes. It happens before the
deadline, in time that the loop sleeps through anyway: once in good time, when it takes as long as a
cold tick does, and once again shortly before, where that one may be forgotten already.
"""

from collections.abc import Callable
from dataclasses import dataclass

from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.loop.bell import Bell
from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.messages.codec import encode_command
from reflexarc_runtime.serving.swapping import AnyController


class Rehearsal:
    """Knows the last tick, and does it again.

    Args:
        controller: of the loop.
    """

    def __init__(self, controller: AnyController) -> None:
        self._controller = controller
        self._last: tuple[State, Inputs, int] | None = None

    def note(self, before: State, inputs: Inputs, now_ns: int) -> None:
        """A tick was made of this; one with a message does more than one without."""
        if inputs.messages or self._last is None:
            self._last = before, inputs, now_ns

    def __call__(self) -> None:
        """Do it again; nothing comes of it."""
        if self._last is None:
            return
        try:
            _, decision = self._controller.step(*self._last)
        except DecisionEndedError:  # by the watchdog: the tick itself will be told
            return
        encode_command(decision.command)


LONGEST_NS = 1_000_000
"""What takes longer is held up by its arithmetic, and not by cold caches."""
TRIED_AGAIN_AFTER = 100
"""Deadlines: once it may have taken long by chance."""


@dataclass
class Occasion:
    """One time before each deadline at which it is rehearsed.

    Args:
        margin_ns: how long before the deadline it should have ended.
        most_share: of the whole sleep that it may take; a large network is not computed twice.
    """

    margin_ns: int
    most_share: float
    took_ns: int | None = None
    """Last time; None before the first."""
    left_out: int = 0
    """How often since, as it took too long."""

    def before(
        self, deadline_ns: int, sleep_ns: int, clock: Clock, rehearse: Callable[[], None]
    ) -> None:
        """Sleep until it is time, and rehearse, if there is time enough.

        Args:
            deadline_ns: when the next tick begins.
            sleep_ns: how long before that the loop began to sleep.
            clock: by which it sleeps.
            rehearse: what to do.
        """
        takes_ns = sleep_ns // 2 if self.took_ns is None else self.took_ns
        most_ns = min(LONGEST_NS, self.most_share * sleep_ns)
        is_long = self.took_ns is not None and takes_ns > most_ns
        if is_long and self.left_out < TRIED_AGAIN_AFTER:
            self.left_out += 1
            return
        self.left_out = 0
        begin_ns = deadline_ns - self.margin_ns - takes_ns
        if begin_ns <= clock.now_ns():
            return
        clock.sleep_until_ns(begin_ns)
        began_ns = clock.now_ns()
        if began_ns - begin_ns < self.margin_ns // 2:  # else it overslept, and a tick is near
            rehearse()
            self.took_ns = clock.now_ns() - began_ns


class RehearsingClock:
    """A clock that rehearses before it returns from a sleep.

    Args:
        clock: by which it sleeps.
        rehearse: what it does.
    """

    def __init__(self, clock: Clock, rehearse: Callable[[], None]) -> None:
        self._clock, self._rehearse = clock, rehearse
        self.now_ns = clock.now_ns  # asked at every phase of a tick
        self._occasions = Occasion(300_000, 0.03), Occasion(80_000, 0.3)

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        sleep_ns = deadline_ns - self._clock.now_ns()
        for occasion in self._occasions:
            occasion.before(deadline_ns, sleep_ns, self._clock, self._rehearse)
        self._clock.sleep_until_ns(deadline_ns)

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        """See `Clock.wait_until_ns`; nothing is rehearsed, as a ring may come at any time."""
        return self._clock.wait_until_ns(deadline_ns, bell)
