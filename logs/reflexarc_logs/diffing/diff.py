"""Compares two logs of anybody: what is missing on either side, which fields differ, how much.

Both files are read twice: to count what there is, and to compare it. Messages whose bytes are equal
are equal; the others are compared by columns, and decoded where that cannot be.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

from reflexarc_logs.diffing.counting import CountedStreams, count_messages, count_tables
from reflexarc_logs.diffing.diff_report import DiffReport
from reflexarc_logs.diffing.diff_rules import DiffRules
from reflexarc_logs.diffing.message_file import MessageFile, StreamMessage
from reflexarc_logs.diffing.topic_comparison import TopicComparison

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
    counted = count_tables(files[0].tables()), count_tables(files[1].tables())
    report = _compared((str(a), str(b)), (files[0].messages, files[1].messages), counted, rules)
    notes = [f"{f.path} is cut: what there is of it was compared" for f in files if f.was_cut]
    return replace(report, notes=(*report.notes, *notes))


def diff_messages(
    names: tuple[str, str],
    sides: tuple[Reading, Reading],
    rules: DiffRules = USUAL_RULES,
    *,
    by_columns: bool = True,
) -> DiffReport:
    """Compare two sequences of messages by topic and field.

    Args:
        names: what both are called.
        sides: reads one, and the other; called twice.
        rules: see `diff`.
        by_columns: whether many messages are compared at once; else each pair is walked, which
            takes longer and finds the same.

    Raises:
        LogError: from the reading.
    """
    counted = count_messages(sides[0]()), count_messages(sides[1]())
    return _compared(names, sides, counted, rules, by_columns=by_columns)


def _compared(
    names: tuple[str, str],
    sides: tuple[Reading, Reading],
    counted: tuple[CountedStreams, CountedStreams],
    rules: DiffRules,
    *,
    by_columns: bool = True,
) -> DiffReport:
    topics = sorted({*counted[0], *counted[1]})
    streams = {t: (counted[0].get(t) or counted[1][t]).stream for t in topics}
    ignored = tuple(t for t in topics if rules.ignores(streams[t]))
    comparisons = {
        t: TopicComparison(rules, counted[0].get(t), counted[1].get(t), by_columns=by_columns)
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


def _side_by_side(
    sides: tuple[Reading, Reading], totals: list[int]
) -> Iterator[tuple[int, StreamMessage]]:
    """The messages of both sides in step with each other, so that few have to wait."""
    readers = [iter(read()) for read in sides]
    read, steps = [0, 0], [max(total, 1) for total in reversed(totals)]
    while read[0] < totals[0] or read[1] < totals[1]:
        side = 0 if read[0] * steps[0] <= read[1] * steps[1] else 1
        if read[side] >= totals[side]:
            side = 1 - side
        read[side] += 1
        yield side, next(readers[side])
