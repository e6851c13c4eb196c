"""Processes that a life of a service has left behind, zombies among them, by /proc."""

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from support.service_life import Life

_STARTED = 16
"""Where /proc/PID/stat says when it began, behind state, parent and group: proc(5), field 22."""
GRACE_S = 2.0
"""What is killed with its group takes a moment to end, and to be waited for."""


def leftovers(lives: Sequence[Life]) -> list[str]:
    """What is there of lives that have ended, in words."""
    end_s = time.monotonic() + GRACE_S
    while (found := list(_of_groups(lives))) and time.monotonic() < end_s:
        time.sleep(0.02)
    return found


def _of_groups(lives: Sequence[Life]) -> Iterator[str]:
    ended_s = {life.pid: life.ended_s or 0.0 for life in lives}
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = place.read_text().partition("(")[2].rpartition(")")
        except OSError:  # it has ended meanwhile
            continue
        state, _, group, *more = rest.split()
        # The kernel gives numbers again: who began after the end has but the number of a life.
        began_s = int(more[_STARTED]) / os.sysconf("SC_CLK_TCK") - _suspended_s()
        if began_s <= ended_s.get(int(group), -1.0):
            yield f"left over: {name}, process {place.parent.name}, state {state}"


def _suspended_s() -> float:
    """How long the machine slept since its start, which the monotonic clock does not count."""
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()
