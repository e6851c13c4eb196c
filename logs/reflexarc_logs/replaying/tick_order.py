"""In which order the ticks of a log stand, and which of them are missing."""

from collections.abc import Iterator

from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages_pb2 import Decision

_STOPPED = Verdict.STOPPED.value


def is_tick(decision: Decision, number: int) -> bool:
    """Whether a decision is that of this tick: one of the two places that name it may be wrong.

    So a number that was changed is a difference, and a tick that is missing is none.
    """
    return number == decision.index or number == decision.command.sequence


class TickOrder:
    """The ticks of one loop, as they come."""

    def __init__(self) -> None:
        self.ticks = 0
        self.first = 0
        self.missing = 0
        """Ticks whose neighbours are there."""
        self.first_missing = 0
        self.behind = 0
        """Ticks whose turn was before."""
        self.restarts = 0
        """How often a tick 0 came behind others."""
        self._next = 0
        self.ended = False
        """Whether the latest one is the stop that ends a run."""

    def saw(self, decision: Decision) -> None:
        """Take the next tick."""
        number = decision.index
        if number != self._next and is_tick(decision, self._next):
            number = self._next
        if not self.ticks:
            self.first = number
        elif number > self._next:
            self.first_missing = self.first_missing if self.missing else self._next
            self.missing += number - self._next
        elif number < self._next:
            self.behind += 1
            self.restarts += number == 0
        self.ticks += 1
        self._next = number + 1 if number == 0 else max(self._next, number + 1)
        self.ended = decision.verdict == _STOPPED

    def saw_run(self, first: int, count: int) -> bool:
        """Take so many ticks without a gap, none of them the last; False if others come next."""
        if not self.ticks or first != self._next:
            return False
        self.ticks += count
        self._next += count
        self._ended = False
        return True

    def notes(self) -> Iterator[str]:
        """What is missing, and what stands where it should not."""
        if not self.ticks:
            return
        absent = ["before"] * bool(self.first) + ["after"] * (not self.ended)
        if absent:
            where = f"ticks {self.first} to {self._next - 1}"
            yield f"it holds {where}: what came {' and '.join(absent)} is not in it"
        if self.missing:
            yield f"{self.missing} ticks are missing, the first is tick {self.first_missing}"
        if self.behind:
            yield f"{self.behind} ticks stand twice, or out of order"
