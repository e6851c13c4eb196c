"""The ticks of a log: which of them are missing, and which deadlines were skipped."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from google.protobuf.message import DecodeError

from reflexarc_logs.checking.findings import LogFinding, error, warning
from reflexarc_logs.replaying.tick_order import TickOrder
from reflexarc_runtime.messages_pb2 import Decision, Tick


@dataclass(slots=True)
class Skips:
    """Slots without a tick."""

    tolerated: int = 0
    """So many in a row are not counted."""
    count: int = 0
    first: int = 0
    """The tick behind the first of them."""

    def saw(self, skipped: int, index: int) -> None:
        """Take the slots that were left out before a tick."""
        beyond = skipped - self.tolerated
        if beyond > 0:
            self.first = self.first if self.count else index
            self.count += beyond


@dataclass(slots=True)
class TickCourse:
    """The ticks of one sender, in file order."""

    order: TickOrder = field(default_factory=TickOrder)
    at_a_rate: Skips = field(default_factory=Skips)
    at_inputs: Skips = field(default_factory=lambda: Skips(tolerated=1))
    """The same for a loop that is paced by its inputs: it leaves a slot out where its sensor is
    slower than the rate, or where an input came too early."""
    unreadable: int = 0
    _last: tuple[int, int] | None = None
    """Index and slot."""

    def add(self, payload: bytes) -> None:
        """Take the next tick."""
        try:
            decision = Tick.FromString(payload).decision
        except DecodeError:
            self.unreadable += 1
            return
        self.order.saw(decision)
        self._skip(decision)

    def findings(self, *, is_whole: bool, pace: str = "") -> Iterator[LogFinding]:
        """What is amiss with them.

        Args:
            is_whole: whether the log should hold a run from its first tick to its last.
            pace: of the loop, as the log names it.
        """
        order = self.order
        if self.unreadable:
            yield error("bytes", f"{self.unreadable} ticks cannot be decoded")
        if order.missing:
            first = order.first_missing
            yield error("completeness", f"{order.missing} ticks are missing, from tick {first} on")
        if order.behind:
            yield error("completeness", f"{order.behind} ticks stand twice, or out of order")
        if is_whole and order.first:
            yield warning("completeness", f"it begins with tick {order.first}, not with tick 0")
        if is_whole and not order.ended:
            yield warning("completeness", "it ends before its loop did: the last tick is no stop")
        skips = self.at_inputs if pace == "input" else self.at_a_rate
        if skips.count:
            at = f"the first before tick {skips.first}"
            yield warning("gaps", f"{skips.count} deadlines of the loop were skipped, {at}")

    def _skip(self, decision: Decision) -> None:
        before, self._last = self._last, (decision.index, decision.slot)
        if before is None or decision.index != before[0] + 1:
            return
        skipped = decision.slot - before[1] - 1
        self.at_a_rate.saw(skipped, decision.index)
        self.at_inputs.saw(skipped, decision.index)
