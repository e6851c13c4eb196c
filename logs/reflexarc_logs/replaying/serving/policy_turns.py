"""The ticks of a log by who decided them: one turn after another."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.serving.swapping import says_rolled_back


@dataclass(frozen=True)
class PolicyTurn:
    """Ticks in a row that one policy decided, since it took over."""

    policy_hash: str
    """Empty: the one that the log names."""
    begins: int | None
    """The tick at which it took over; None: it is the first turn."""
    ticks: Iterator[Tick | TickRun]


def turns_of(ticks: Iterable[Tick | TickRun], named: str) -> Iterator[PolicyTurn]:
    """The turns of a log; each is to be read before the next.

    Args:
        ticks: of one loop, in order.
        named: the hash of the policy that the log names: runs of ticks are of that one.
    """
    last, turn, index = "", 0, 0

    def place(found: Tick | TickRun) -> tuple[int, str, int]:
        """The number of the turn, whose it is, and the tick that was to come when it began."""
        nonlocal last, turn, index
        mine, anew, end = named, False, 0
        if isinstance(found, TickRun):
            end = found.first + len(found)
        else:
            decision = found.decision
            mine, end = decision.policy_hash or named, decision.index + 1
            anew = says_rolled_back(decision.reason)
        if turn == 0 or mine != last or anew:
            turn, last = turn + 1, mine
            start.append(index)
        index = end
        return turn, mine, start[-1]

    start: list[int] = []
    for (number, mine, begins), part in groupby(ticks, place):
        yield PolicyTurn(mine, None if number == 1 else begins, part)
