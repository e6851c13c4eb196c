"""Processes that a life of a service has left behind, zombies among them, by /proc."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from support.service_life import Life

GRACE_S = 2.0
"""What is killed with its group takes a moment to end, and to be waited for."""


def leftovers(lives: Sequence[Life]) -> list[str]:
    """What is there of lives that have ended, in words."""
    groups = {life.pid for life in lives}
    end_s = time.monotonic() + GRACE_S
    while (found := list(_of_groups(groups))) and time.monotonic() < end_s:
        time.sleep(0.02)
    return found


def _of_groups(groups: set[int]) -> Iterator[str]:
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = place.read_text().partition("(")[2].rpartition(")")
        except OSError:  # it has ended meanwhile
            continue
        state, _, group = rest.split()[:3]
        if int(group) in groups:
            yield f"left over: {name}, process {place.parent.name}, state {state}"
