"""Asks the kernel for what a loop needs to wake on time, and gives it back.

Without rights: a timer slack of 1 ns (the kernel's default of 50 µs is most of the lateness of an
idle machine), start-up objects that the garbage collector no longer visits, and short turns: a
thread that computes in Python gives the interpreter's lock away after 0.1 ms, in place of 5.

With a priority N the loop's thread is scheduled first in, first out. The watchdog's gets one more:
it must come through where the loop spins on the last processor; where N + 1 is refused, it gets N,
and the loop N − 1. All other threads of the process get the lowest such priority, 1: each of them
holds the interpreter's lock at times, and one that loses its processor to some other process
meanwhile holds up the loop for as long.
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import suppress
from types import TracebackType
from typing import Self

from reflexarc_runtime.loop.realtime.grant import Grant, in_words
from reflexarc_runtime.loop.realtime.kernel import Kernel, LinuxKernel
from reflexarc_runtime.loop.realtime.realtime_settings import RealtimeSettings
from reflexarc_runtime.loop.realtime.thread_scheduling import (
    LEAST_PRIORITY,
    ThreadScheduling,
    reason,
)

TURN_S = 0.0001
"""Shorter ones gain nothing, and cost whoever computes."""


class Realtime:
    """What a thread obtained; a context manager, which asks at its beginning and gives back.

    To be entered by the loop's thread. Which threads it starts from then on inherit its processors,
    and no priority: `take_in` gives them what the others have.

    Args:
        settings: what is asked.
        kernel: of whom.
    """

    def __init__(self, settings: RealtimeSettings, kernel: Kernel | None = None) -> None:
        self._settings = settings
        self._kernel = kernel or LinuxKernel()
        self._handle: int | None = None
        self._has_locked = False
        self.grants: tuple[Grant, ...] = ()

    def __enter__(self) -> Self:
        self._threads = ThreadScheduling(self._kernel)
        self._usual_turn_s = sys.getswitchinterval()
        self.grants = tuple(self._ask())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.give_back()

    @property
    def words(self) -> str:
        """What was obtained, and what was refused, on one line."""
        return in_words(self.grants)

    def take_in(self) -> None:
        """Ask for the threads that have begun since; to be called before the first tick."""
        refusal = self._threads.take_in()
        if refusal:
            again = self._others_behind(refusal)
            self.grants = tuple(again if g.asked == again.asked else g for g in self.grants)

    def give_back(self) -> None:
        """Schedule, lock and hold nothing any more; what was set without a right stays."""
        kernel = self._kernel
        self._threads.give_back()
        sys.setswitchinterval(self._usual_turn_s)
        if self._has_locked:
            with suppress(OSError):
                kernel.unlock_memory()
        if self._handle is not None:
            kernel.release(self._handle)
        self._has_locked, self._handle = False, None

    def _ask(self) -> Iterator[Grant]:
        settings = self._settings
        yield self._timer_slack()
        yield _frozen_collector()
        yield _short_turns()
        if settings.processors:
            yield self._processors()
        if settings.whole_machine:
            yield self._memory()
            yield self._wake_latency()
            yield self._governor()
        if settings.priority:
            yield from self._priorities()

    def _timer_slack(self) -> Grant:
        asked = "timer slack 1 ns"
        try:
            self._kernel.set_timer_slack(1)
        except OSError as error:
            return Grant(asked, "", reason(error), "use a Linux kernel", is_needed=False)
        return Grant(asked, asked)

    def _priorities(self) -> Iterator[Grant]:
        """Of loop, watchdog and others; where the watchdog's is refused, all are one less."""
        wanted, above = self._settings.priority, self._settings.highest_priority
        watch, refusal = self._threads.highest_granted(above, *[wanted] * (wanted > 1))
        right = _right_to(above) if refusal else ""
        loop = max(0, watch - 1)
        got = f"SCHED_FIFO {loop}" if loop else ""
        yield Grant(f"SCHED_FIFO {wanted}", got, refusal, right)
        if loop:
            self._threads.put_loop_first(loop)
            yield Grant(f"watchdog {above}", f"watchdog {watch}", refusal, right)
            yield self._others_behind(self._threads.put_others_behind(watch))

    def _others_behind(self, refusal: str) -> Grant:
        asked = f"other threads {LEAST_PRIORITY}"
        if refusal:
            return Grant(asked, "", refusal, _right_to(self._settings.highest_priority))
        return Grant(asked, asked)

    def _processors(self) -> Grant:
        wanted = set(self._settings.processors)
        asked = f"processors {_listed(wanted)}" if len(wanted) > 1 else f"processor {min(wanted)}"
        allowed = f"of those allowed here: {_listed(self._threads.processors)}"
        try:
            got = self._threads.run_loop_on(wanted)
        except OSError as error:
            return Grant(asked, "", reason(error), f"name one {allowed}")
        if got != wanted:  # the kernel takes those that there are, and says nothing
            return Grant(asked, _listed(got), "the others are not there", f"name some {allowed}")
        return Grant(asked, asked)

    def _memory(self) -> Grant:
        """Where a limit holds, what is mapped later is not locked: it could not be mapped then."""
        asked, remedy = "memory locked", "ulimit -l unlimited, LimitMEMLOCK=infinity (systemd)"
        try:
            future = self._kernel.may_lock_without_limit()
            self._kernel.lock_memory(future=future)
        except OSError as error:
            return Grant(asked, "", reason(error), remedy)
        self._has_locked = True
        if future:
            return Grant(asked, asked)
        return Grant(asked, "what there is so far", "RLIMIT_MEMLOCK is finite", remedy)

    def _wake_latency(self) -> Grant:
        """No machine needs it that does not sleep deeply; a virtual one has none."""
        asked = "no deep sleep of processors"
        try:
            self._handle = self._kernel.hold_wake_latency()
        except OSError as error:
            remedy = "a udev rule that lets a group write /dev/cpu_dma_latency"
            return Grant(asked, "", reason(error), remedy, is_needed=False)
        return Grant(asked, asked)

    def _governor(self) -> Grant:
        """It is the machine's, and only read."""
        asked = "governor performance"
        try:
            governor = self._kernel.governor()
        except OSError:
            return Grant(asked, "no governor here", is_needed=False)
        if governor == "performance":
            return Grant(asked, asked)
        remedy = "cpupower frequency-set -g performance"
        return Grant(asked, "", f"it is {governor}", remedy, is_needed=False)


def prepare(fifo_priority: int = 0) -> list[str]:
    """Prepare this thread for a loop at a fixed rate, for as long as it lives.

    Args:
        fifo_priority: 1 to 98 for SCHED_FIFO; 0 leaves the scheduling as it is.

    Returns:
        What was obtained, and what was refused, a phrase each.
    """
    return [grant.words for grant in Realtime(RealtimeSettings(fifo_priority)).__enter__().grants]


def _frozen_collector() -> Grant:
    gc.collect()
    gc.freeze()
    return Grant("collector frozen", "collector frozen")


def _short_turns() -> Grant:
    sys.setswitchinterval(min(TURN_S, sys.getswitchinterval()))
    return Grant("turns of 0.1 ms", "turns of 0.1 ms")


def _right_to(priority: int) -> str:
    return (
        f"ulimit -r {priority} (rtprio in /etc/security/limits.d), "
        f"LimitRTPRIO={priority} (systemd), or CAP_SYS_NICE"
    )


def _listed(processors: set[int]) -> str:
    return ", ".join(map(str, sorted(processors)))
