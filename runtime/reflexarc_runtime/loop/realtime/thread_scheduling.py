"""How the threads of a process are scheduled beside its loop, and on which processors they run.

A thread begins with the scheduling and the processors of the thread that starts it. The loop's lets
nothing inherit its priority, so what it starts is scheduled as usual, on the loop's processors;
what the others start has the lowest priority, and keeps it. So who began since the loop was given
its own is asked for later, and who began at any time is given back what was usual before.
"""

import os
from collections.abc import Iterator
from contextlib import suppress

from reflexarc_runtime.loop.realtime.kernel import Kernel, Scheduling

WATCHDOG = "watchdog"
"""Name of the thread that must run even where the loop does not let go."""
LEAST_PRIORITY = 1


class ThreadScheduling:
    """What each thread has, and had before; for the loop's thread, which alone may ask.

    Args:
        kernel: of whom.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._loop = kernel.this_thread()
        self._known = {self._loop}
        """Threads that were asked for, or were there before the loop had its processors."""
        self._before: dict[int, Scheduling] = {}
        self._watch_priority = 0
        self._processors_before: set[int] = set()
        self._refusal = ""

    def run_loop_on(self, processors: set[int]) -> set[int]:
        """Let the loop's thread run on these alone; those that it got.

        Raises:
            OSError: none of them may be used.
        """
        kernel, before = self._kernel, self.processors
        kernel.use_processors(self._loop, processors)
        self._processors_before = before
        self._known |= kernel.threads().keys()
        return self.processors

    @property
    def processors(self) -> set[int]:
        """Those of the loop's thread."""
        return self._kernel.processors(self._loop)

    def put_loop_first(self, priority: int) -> None:
        """Schedule the loop's thread first in, first out; what it starts now is scheduled as usual.

        Raises:
            OSError: it is refused.
            AttributeError: there is no such thing here.
        """
        self._schedule(self._loop, (os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, priority))

    def highest_granted(self, *priorities: int) -> tuple[int, str]:
        """The first of these that the loop's thread is given, else 0; and why not one before.

        A run is tried before it begins, when it has no other thread yet.
        """
        refusal = ""
        for priority in priorities:
            try:
                self.put_loop_first(priority)
            except (OSError, AttributeError) as error:
                refusal = reason(error)
            else:
                return priority, refusal
        return 0, refusal

    def put_others_behind(self, watch_priority: int) -> str:
        """Schedule all other threads, the watchdog with this priority; why some of them are not."""
        self._watch_priority = watch_priority
        for thread, name in self._each_thread_once():
            if thread != self._loop:
                self._put(thread, watch_priority if name == WATCHDOG else LEAST_PRIORITY)
        return self._refusal

    def take_in(self) -> str:
        """Do it for those that began since, on the processors of before; why not for some."""
        if not (self._watch_priority or self._processors_before):
            return ""
        for thread, _ in self._each_thread_once():
            if thread not in self._known:
                self._move_back(thread)
                if self._watch_priority:
                    self._put(thread, LEAST_PRIORITY)
        return self._refusal

    def give_back(self) -> None:
        """Schedule each thread as it was before, those that began later as the loop's was."""
        if self._before or self._processors_before:
            for thread, _ in self._each_thread_once():
                self._give_processors_back(thread)
                self._give_scheduling_back(thread)
        self._before, self._processors_before, self._watch_priority = {}, set(), 0

    def _each_thread_once(self) -> Iterator[tuple[int, str]]:
        """Those that one of them starts meanwhile as well; each with its name."""
        seen: set[int] = set()
        while new := {t: name for t, name in self._kernel.threads().items() if t not in seen}:
            yield from new.items()
            seen.update(new)

    def _put(self, thread: int, priority: int) -> None:
        try:
            self._schedule(thread, (os.SCHED_FIFO, priority))
        except ProcessLookupError:
            return  # it has ended
        except (OSError, AttributeError) as error:
            self._refusal = reason(error)

    def _schedule(self, thread: int, scheduling: Scheduling) -> None:
        before = self._kernel.scheduling(thread)
        self._kernel.schedule(thread, scheduling)
        self._before.setdefault(thread, before)
        self._known.add(thread)

    def _schedule_again(self, thread: int, scheduling: Scheduling) -> None:
        """As before; who has no right to let a thread inherit again leaves that as it is."""
        policy, priority = scheduling
        for again in (policy, policy | os.SCHED_RESET_ON_FORK):
            with suppress(OSError):  # it has ended
                self._kernel.schedule(thread, (again, priority))
                return

    def _give_scheduling_back(self, thread: int) -> None:
        if thread in self._before:
            self._schedule_again(thread, self._before[thread])
        elif self._before and self._has_least(thread):
            self._schedule_again(thread, self._before[self._loop])

    def _has_least(self, thread: int) -> bool:
        """Whether a thread has the priority that one of the others started it with."""
        with suppress(OSError):  # it has ended
            return self._kernel.scheduling(thread) == (os.SCHED_FIFO, LEAST_PRIORITY)
        return False

    def _give_processors_back(self, thread: int) -> None:
        if thread == self._loop or thread not in self._known:
            self._move_back(thread)

    def _move_back(self, thread: int) -> None:
        """Let a thread run where the loop's did, and so all that it started."""
        if self._processors_before:
            with suppress(OSError):  # it has ended
                self._kernel.use_processors(thread, self._processors_before)


def reason(error: Exception) -> str:
    """Why the kernel refuses, in words."""
    return (getattr(error, "strerror", None) or str(error)).lower()
