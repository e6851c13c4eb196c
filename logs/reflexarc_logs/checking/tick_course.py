"""The ticks of a log: which of them are missing, and which deadlines were skipped."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from google.protobuf.message import DecodeError

from reflexarc_logs.checking.findings import LogFinding, error, warning
from reflexarc_logs.replaying.tick_order import TickOrder
from reflexarc_runtime.messages_pb2 import Decision, Tick


@dataclass(slots=True)
class TickCourse:
    """The ticks of one sender, in file order."""

    order: TickOrder = field(default_factory=TickOrder)
    skipped: int = 0
    """Deadlines at which there was no tick."""
    first_skipped: int = 0
    """The tick behind the first of them."""
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

    def findings(self, *, is_whole: bool) -> Iterator[LogFinding]:
        """What is amiss with them.

        Args:
            is_whole: whether the log should hold a run from its first tick to its last.
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
        if self.skipped:
            at = f"the first before tick {self.first_skipped}"
            yield warning("gaps", f"{self.skipped} deadlines of the loop were skipped, {at}")

    def _skip(self, decision: Decision) -> None:
        before, self._last = self._last, (decision.index, decision.slot)
        if before is None or decision.index != before[0] + 1:
            return
        skipped = decision.slot - before[1] - 1
        if skipped > 0:
            self.first_skipped = self.first_skipped if self.skipped else decision.index
            self.skipped += skipped
