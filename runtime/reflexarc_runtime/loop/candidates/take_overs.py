"""Who took over in a run: all of them are counted, and the last ones remembered."""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

MOST_REMEMBERED = 100


class ServedSince(NamedTuple):
    """A policy that took over."""

    policy_hash: str
    tick: int


@dataclass(frozen=True)
class TakeOvers:
    """Who took over in a run."""

    count: int = 0
    last: tuple[ServedSince, ...] = ()
    """The last ones, at most `MOST_REMEMBERED`."""


class TakeOverCount:
    """Counts them."""

    def __init__(self) -> None:
        self._count = 0
        self._last: deque[ServedSince] = deque(maxlen=MOST_REMEMBERED)

    @property
    def so_far(self) -> TakeOvers:
        """Those since the start."""
        return TakeOvers(self._count, tuple(self._last))

    def note(self, one: ServedSince) -> None:
        """One more has taken over."""
        self._count += 1
        self._last.append(one)
