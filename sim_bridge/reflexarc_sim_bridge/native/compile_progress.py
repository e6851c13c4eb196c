"""What is being compiled and how long that will still take, for whoever shows it to a person.

Whoever compiles names the parts and the seconds that each takes on a machine of medium speed. How
much slower or faster this machine is follows from the parts that are done.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TypeAlias

Watcher: TypeAlias = Callable[["Compilation"], AbstractContextManager[object]]
"""Entered when a compilation begins, and left when it ends."""

_LONGEST_FACTOR, _SHORTEST_FACTOR = 20.0, 0.05
_watchers: list[Watcher] = []


class Compilation:
    """Parts that are compiled one after another.

    Args:
        parts: what is compiled, in words, and how many seconds it is expected to take.
        clock: seconds that never go back.
    """

    def __init__(
        self, parts: Mapping[str, float], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._waiting, self._clock = dict(parts), clock
        self._expected_s = self._taken_s = 0.0
        self._current_s, self._began_s = 0.0, clock()
        self.current = ""
        """The part that is compiled now."""

    @property
    def left_s(self) -> float:
        """Seconds that it will still take, as far as can be foreseen."""
        factor = self._taken_s / self._expected_s if self._expected_s else 1.0
        factor = min(max(factor, _SHORTEST_FACTOR), _LONGEST_FACTOR)
        current_s = self._current_s * factor - (self._clock() - self._began_s)
        return max(0.0, current_s) + factor * sum(self._waiting.values())

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Within the context a part is compiled; one that nobody named takes no time."""
        self.current, self._current_s = name, self._waiting.pop(name, 0.0)
        self._began_s = self._clock()
        yield
        self._expected_s += self._current_s
        self._taken_s += self._clock() - self._began_s
        self._current_s, self._began_s = 0.0, self._clock()


@contextmanager
def compilation(parts: Mapping[str, float]) -> Iterator[Compilation]:
    """A compilation that the latest watcher is told of; without parts no watcher is called."""
    begun = Compilation(parts)
    with _watchers[-1](begun) if _watchers and parts else nullcontext():
        yield begun


@contextmanager
def watched_by(watcher: Watcher) -> Iterator[None]:
    """Within the context a watcher is told of every compilation of this process."""
    _watchers.append(watcher)
    try:
        yield
    finally:
        _watchers.remove(watcher)
