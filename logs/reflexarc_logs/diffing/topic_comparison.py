"""One topic of two logs while it is compared: pair by pair, or many pairs at once by columns."""

from collections.abc import Iterator

from reflexarc_logs.diffing.alignment import Census, Matched, Pairing, chosen
from reflexarc_logs.diffing.column_comparison import ColumnComparison, ColumnDiff
from reflexarc_logs.diffing.counting import CountedStream
from reflexarc_logs.diffing.diff_report import FieldDiff, FirstAt, TopicDiff, shown
from reflexarc_logs.diffing.diff_rules import DiffRules, without_indices
from reflexarc_logs.diffing.field_values import FieldRules, Unequal
from reflexarc_logs.diffing.message_file import StreamMessage
from reflexarc_logs.diffing.payloads import Payloads, UnreadableError

_PAIRS_AT_ONCE = 4096
_BYTES_AT_ONCE = 1 << 20
_LEAST_AT_ONCE = 8
"""Fewer pairs are sooner walked."""


class TopicComparison:
    """Compares one topic.

    Args:
        rules: what counts.
        a: the topic in one log; None: it is not there.
        b: in the other one.
        by_columns: whether many pairs are compared at once.
    """

    def __init__(
        self,
        rules: DiffRules,
        a: CountedStream | None,
        b: CountedStream | None,
        *,
        by_columns: bool = True,
    ) -> None:
        self._a, self._b = a, b
        stream = (a or b).stream  # type: ignore[union-attr]  # one of them is there
        counts = [Census() if one is None else one.census for one in (a, b)]
        how = chosen(rules.alignment(stream), *counts)
        self._pairing = Pairing(how)
        self._rules = FieldRules(rules.ignored_fields(stream), rules.tolerances(stream))
        streams = [one.stream for one in (a or b, b or a) if one is not None]
        self._payloads = Payloads(streams[0], streams[1], self._rules.ignored.cover)
        kind = self._payloads.kind if by_columns else None
        self._columns = None if kind is None else ColumnComparison(kind, self._rules)
        self._gathered: list[tuple[int, StreamMessage, StreamMessage]] = []
        self._gathered_bytes = 0
        self.topic = TopicDiff(
            stream.topic, stream.type_name, how, counts[0].count, counts[1].count
        )

    def add(self, side: int, message: StreamMessage) -> None:
        """Take a message, and compare what is paired now."""
        if self._a is None or self._b is None:
            self._count_alone(
                Matched(self.topic.only_a + self.topic.only_b, *_placed(side, message))
            )
            return
        for pair in self._pairing.add(side, message):
            self._compare(pair)

    def end(self) -> None:
        """Count what has nothing to belong to."""
        for pair in self._pairing.rest():
            self._compare(pair)
        if self._columns is not None:
            self._compare_gathered(self._columns)
        if self.topic.fields and not self._payloads.are_decoded:
            self.topic.notes.append("compared as bytes: its schema cannot be decoded here")

    def _compare(self, pair: Matched) -> None:
        if pair.a is None or pair.b is None:
            self._count_alone(pair)
            return
        self.topic.paired += 1
        if self._payloads.are_equal(pair.a.payload, pair.b.payload):
            self.topic.identical += 1
        elif self._columns is None:
            self._walk(pair.number, pair.a, pair.b)
        else:
            self._gather(self._columns, pair.number, pair.a, pair.b)

    def _walk(self, number: int, a: StreamMessage, b: StreamMessage) -> None:
        """Compare one pair, and count what differs."""
        unequal = list(self._unequal(a, b))
        self.topic.identical += not unequal
        for one in unequal:
            found = self._introduced(one, number, a)
            found.differences += 1
            if (apart := one.apart) is not None:
                found.largest = max(apart, found.largest or 0.0)

    def _gather(
        self, columns: ColumnComparison, number: int, a: StreamMessage, b: StreamMessage
    ) -> None:
        """Keep a pair until there are many."""
        self._gathered.append((number, a, b))
        self._gathered_bytes += len(a.payload) + len(b.payload)
        if len(self._gathered) >= _PAIRS_AT_ONCE or self._gathered_bytes >= _BYTES_AT_ONCE:
            self._compare_gathered(columns)

    def _compare_gathered(self, columns: ColumnComparison) -> None:
        """Compare what was kept: as if each pair were walked, in their order."""
        pairs, self._gathered, self._gathered_bytes = self._gathered, [], 0
        if len(pairs) < _LEAST_AT_ONCE:
            for pair in pairs:
                self._walk(*pair)
            return
        found = columns.compare([a.payload for _, a, _ in pairs], [b.payload for _, _, b in pairs])
        self.topic.identical += found.identical
        known, unread = self.topic.fields.keys(), set(found.unread)
        firsts = {one.first for name, one in found.fields.items() if name not in known}
        for row in sorted(firsts | unread):
            number, a, b = pairs[row]
            if row in unread:
                self._walk(number, a, b)
            else:
                for one in self._unequal(a, b):
                    self._introduced(one, number, a)
        for name, column in found.fields.items():
            _add(self.topic.fields[name], column)

    def _unequal(self, a: StreamMessage, b: StreamMessage) -> Iterator[Unequal]:
        if self._payloads.equal(a.payload, b.payload):
            return
        try:
            yield from self._rules.counting(self._payloads.differing(a.payload, b.payload))
        except UnreadableError as error:
            yield Unequal("payload", f"cannot be decoded: {error}", "")

    def _count_alone(self, pair: Matched) -> None:
        message = pair.a or pair.b
        assert message is not None
        first = FirstAt(pair.number, message.sequence, message.log_ns)
        if pair.a is not None:
            self.topic.only_a += 1
            self.topic.first_only_a = self.topic.first_only_a or first
        else:
            self.topic.only_b += 1
            self.topic.first_only_b = self.topic.first_only_b or first

    def _introduced(self, one: Unequal, number: int, message: StreamMessage) -> FieldDiff:
        """The field that differs, with where it did so first."""
        name = without_indices(one.path)
        found = self.topic.fields.setdefault(name, FieldDiff(name))
        if found.first is None:
            place = number, message.sequence, message.log_ns
            found.first = FirstAt(*place, one.path, shown(one.a), shown(one.b))
        return found


def _add(found: FieldDiff, column: ColumnDiff) -> None:
    found.differences += column.differences
    if column.largest is not None:
        found.largest = max(column.largest, found.largest or 0.0)


def _placed(side: int, message: StreamMessage) -> tuple[StreamMessage | None, StreamMessage | None]:
    return (message, None) if side == 0 else (None, message)
