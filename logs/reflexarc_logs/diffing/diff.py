"""Compares two logs of anybody: what is missing on either side, which fields differ, how much.

Both files are read twice: to count what there is, and to compare it. Messages whose bytes are equal
are equal; only the others are decoded.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from reflexarc_logs.diffing.alignment import Census, Matched, Pairing, chosen
from reflexarc_logs.diffing.diff_report import DiffReport, FieldDiff, FirstAt, TopicDiff, shown
from reflexarc_logs.diffing.diff_rules import DiffRules, without_indices
from reflexarc_logs.diffing.field_values import FieldRules, Unequal
from reflexarc_logs.diffing.message_file import MessageFile, Stream, StreamMessage
from reflexarc_logs.diffing.payloads import Payloads, UnreadableError

USUAL_RULES = DiffRules()

Reading: TypeAlias = Callable[[], Iterable[StreamMessage]]


def diff(a: Path | str, b: Path | str, rules: DiffRules = USUAL_RULES) -> DiffReport:
    """Compare two MCAP files by topic and field.

    Args:
        a: one file; protobuf, CDR of ROS 2 (with the extra `ros2`) and JSON are told apart by
            fields, everything else by bytes.
        b: the other one.
        rules: what is passed over, and how far apart values may lie.

    Raises:
        LogError: a file is missing, damaged, or no MCAP file.
    """
    files = MessageFile(Path(a)), MessageFile(Path(b))
    report = diff_messages((str(a), str(b)), (files[0].messages, files[1].messages), rules)
    notes = [f"{f.path} is cut: what there is of it was compared" for f in files if f.was_cut]
    return replace(report, notes=(*report.notes, *notes))


def diff_messages(
    names: tuple[str, str], sides: tuple[Reading, Reading], rules: DiffRules = USUAL_RULES
) -> DiffReport:
    """Compare two sequences of messages by topic and field.

    Args:
        names: what both are called.
        sides: reads one, and the other; called twice.
        rules: see `diff`.

    Raises:
        LogError: from the reading.
    """
    counted = [_count(read()) for read in sides]
    topics = sorted({*counted[0], *counted[1]})
    streams = {t: (counted[0].get(t) or counted[1][t]).stream for t in topics}
    ignored = tuple(t for t in topics if rules.ignores(streams[t]))
    comparisons = {
        t: _Comparison(rules, counted[0].get(t), counted[1].get(t))
        for t in topics
        if t not in ignored
    }
    totals = [sum(one.census.count for one in side.values()) for side in counted]
    for side, message in _side_by_side(sides, totals):
        if comparison := comparisons.get(message.stream.topic):
            comparison.add(side, message)
    for comparison in comparisons.values():
        comparison.end()
    found = tuple(comparison.topic for comparison in comparisons.values())
    return DiffReport(*names, found, ignored)


@dataclass
class _Counted:
    """A stream, and what its first reading says."""

    stream: Stream
    census: Census


def _count(messages: Iterable[StreamMessage]) -> dict[str, _Counted]:
    found: dict[str, _Counted] = {}
    for message in messages:
        counted = found.get(message.stream.topic)
        if counted is None:
            counted = found[message.stream.topic] = _Counted(message.stream, Census())
        counted.census.add(message)
    return found


def _side_by_side(
    sides: tuple[Reading, Reading], totals: list[int]
) -> Iterator[tuple[int, StreamMessage]]:
    """The messages of both sides in step with each other, so that few have to wait."""
    readers = [iter(read()) for read in sides]
    read = [0, 0]
    while read[0] < totals[0] or read[1] < totals[1]:
        side = 0 if read[0] * max(totals[1], 1) <= read[1] * max(totals[0], 1) else 1
        if read[side] >= totals[side]:
            side = 1 - side
        read[side] += 1
        yield side, next(readers[side])


class _Comparison:
    """One topic while it is compared."""

    def __init__(self, rules: DiffRules, a: _Counted | None, b: _Counted | None) -> None:
        self._a, self._b = a, b
        stream = (a or b).stream  # type: ignore[union-attr]  # one of them is there
        counts = [Census() if one is None else one.census for one in (a, b)]
        how = chosen(rules.alignment(stream), *counts)
        self._pairing = Pairing(how)
        self._rules = FieldRules(rules.ignored_fields(stream), rules.tolerances(stream))
        streams = [one.stream for one in (a or b, b or a) if one is not None]
        self._payloads = Payloads(streams[0], streams[1], self._rules.ignored.cover)
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
        if self.topic.fields and not self._payloads.are_decoded:
            self.topic.notes.append("compared as bytes: its schema cannot be decoded here")

    def _compare(self, pair: Matched) -> None:
        if pair.a is None or pair.b is None:
            self._count_alone(pair)
            return
        self.topic.paired += 1
        unequal = list(self._unequal(pair.a, pair.b))
        self.topic.identical += not unequal
        for one in unequal:
            self._count(one, pair.number, pair.a)

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

    def _count(self, one: Unequal, number: int, message: StreamMessage) -> None:
        name = without_indices(one.path)
        found = self.topic.fields.setdefault(name, FieldDiff(name))
        found.differences += 1
        if (apart := one.apart) is not None:
            found.largest = max(apart, found.largest or 0.0)
        if found.first is None:
            place = number, message.sequence, message.log_ns
            found.first = FirstAt(*place, one.path, shown(one.a), shown(one.b))


def _placed(side: int, message: StreamMessage) -> tuple[StreamMessage | None, StreamMessage | None]:
    return (message, None) if side == 0 else (None, message)
