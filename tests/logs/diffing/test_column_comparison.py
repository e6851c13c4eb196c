"""Comparing by columns against walking each pair: the same report, to the last character."""

import dataclasses
import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.diffing import topic_comparison, wire_columns
from reflexarc_logs.diffing.column_comparison import ColumnComparison
from reflexarc_logs.diffing.diff import diff_messages
from reflexarc_logs.diffing.diff_report import DiffReport
from reflexarc_logs.diffing.diff_rules import DiffRules, FieldPatterns, Tolerance
from reflexarc_logs.diffing.field_values import FieldRules
from reflexarc_logs.diffing.message_file import MessageFile, Stream, StreamMessage
from reflexarc_logs.diffing.payloads import protobuf_class
from support.odd_messages import odd_payload, odd_stream, twists

GOLDEN = Path(__file__).parents[2] / "golden"
NO_RULES = DiffRules(ignore=())
SOME_RULES = DiffRules(
    ignore=("*:passed", "*:inner.octets", "*:text", "*:inner.inner"),
    tolerate=(
        Tolerance("*:doubles", absolute=1.0),
        Tolerance("*:inner.*", relative=0.5),
        Tolerance("*:a_int64", absolute=200.0, relative=1e-9),
        Tolerance("*:a_bool", absolute=5.0),
        Tolerance("*:a_double", relative=1.0),
    ),
)


def reports(
    a: Sequence[StreamMessage], b: Sequence[StreamMessage], rules: DiffRules
) -> tuple[DiffReport, DiffReport]:
    """By columns, and pair by pair."""
    sides = (lambda: a, lambda: b)
    return (
        diff_messages(("a", "b"), sides, rules),
        diff_messages(("a", "b"), sides, rules, by_columns=False),
    )


def everything(report: DiffReport) -> str:
    """All that a report says, and in which order."""
    return repr(dataclasses.asdict(report)) + "\n".join([*report.lines(), report.markdown()])


def messages(stream: Stream, payloads: Sequence[bytes]) -> list[StreamMessage]:
    return [StreamMessage(stream, i, 10 * i, 10 * i, data) for i, data in enumerate(payloads)]


@pytest.mark.parametrize("syntax", ["proto3", "proto2"])
@pytest.mark.parametrize("rules", [NO_RULES, SOME_RULES], ids=["no rules", "some rules"])
@pytest.mark.parametrize("oddness", [0.0, 0.01, 0.2])
def test_every_kind_of_field_however_it_is_written(
    monkeypatch: pytest.MonkeyPatch, syntax: str, rules: DiffRules, oddness: float
):
    monkeypatch.setattr(topic_comparison, "_PAIRS_AT_ONCE", 64)
    draw, stream = random.Random(f"{syntax} {oddness}"), odd_stream(syntax)
    sides = [
        messages(stream, [odd_payload(draw, stream, oddness=oddness) for _ in range(160)])
        for _ in range(2)
    ]
    by_columns, one_by_one = reports(sides[0], sides[1], rules)
    assert everything(by_columns) == everything(one_by_one)
    assert one_by_one.exit_status == 1


@pytest.mark.parametrize("syntax", ["proto3", "proto2"])
def test_whole_logs_of_what_few_writers_write(syntax: str):
    """Each strange way as often as a plan takes, against itself and against another value."""
    draw, stream = random.Random(2), odd_stream(syntax)
    base = odd_payload(draw, stream, oddness=0.0)
    for one in twists(draw, base):
        for other in (base, *twists(draw, base)):
            by_columns, one_by_one = reports(
                messages(stream, [one] * 9), messages(stream, [other] * 9), SOME_RULES
            )
            assert everything(by_columns) == everything(one_by_one)


def test_few_values_change_in_messages_that_are_alike():
    draw, stream = random.Random(3), odd_stream()
    ours = [odd_payload(draw, stream, oddness=0.0) for _ in range(300)]
    theirs = list(ours)
    for row in draw.sample(range(300), 60):  # a bit somewhere: a value, a length, a tag
        data = bytearray(theirs[row])
        data[draw.randrange(len(data))] ^= 1 << draw.randrange(8)
        theirs[row] = bytes(data)
    for rules in (NO_RULES, SOME_RULES):
        by_columns, one_by_one = reports(messages(stream, ours), messages(stream, theirs), rules)
        assert everything(by_columns) == everything(one_by_one)


@pytest.mark.parametrize("name", ["nominal", "faults"])
@pytest.mark.parametrize("rules", [DiffRules(), NO_RULES], ids=["usual rules", "no rules"])
def test_golden_logs_of_which_bits_are_changed(name: str, rules: DiffRules):
    """Each message with one in ten of its bytes' lowest bits turned, of every type there is."""
    draw = random.Random(11)
    ours = list(MessageFile(GOLDEN / f"{name}.mcap").messages())
    theirs = [m._replace(payload=_turned(draw, m.payload)) for m in ours]
    by_columns, one_by_one = reports(ours, theirs, rules)
    assert everything(by_columns) == everything(one_by_one)
    assert one_by_one.exit_status == 1


def _turned(draw: random.Random, payload: bytes) -> bytes:
    data = bytearray(payload)
    if data and draw.random() < 0.5:
        data[draw.randrange(len(data))] ^= draw.choice([1, 2, 64, 128])
    return bytes(data)


def test_two_golden_logs_and_their_halves():
    logs = [list(MessageFile(GOLDEN / f"{n}.mcap").messages()) for n in ("nominal", "faults")]
    for ours, theirs in (logs, (logs[0], logs[0][50:]), (logs[0][::2], logs[1])):
        by_columns, one_by_one = reports(ours, theirs, DiffRules())
        assert everything(by_columns) == everything(one_by_one)


def test_many_messages_are_read_by_columns():
    """Else the comparisons above would compare the walk with itself."""
    draw, stream = random.Random(5), odd_stream()
    kind = protobuf_class(stream)
    assert kind is not None
    rules = FieldRules(FieldPatterns(()), ())
    comparison = ColumnComparison(kind, rules)
    payloads = [odd_payload(draw, stream, oddness=0.0) for _ in range(1000)]
    found = comparison.compare(payloads, payloads[1:] + payloads[:1])
    assert len(found.unread) < 800
    read = MessageFile(GOLDEN / "faults.mcap").messages()
    golden = [m for m in read if m.stream.type_name == "reflexarc.Tick"]
    kind = protobuf_class(golden[0].stream)
    assert kind is not None
    ticks = [m.payload for m in golden]
    found = ColumnComparison(kind, rules).compare(ticks, ticks[1:] + ticks[:1])
    assert len(found.unread) < len(ticks) / 4


def test_differences_are_counted_as_they_are_by_hand():
    stream = odd_stream()
    kind = protobuf_class(stream)
    assert kind is not None
    x = kind(floats=[1.0, 0.0, float("nan")], a_int64=2**62, a_bool=True)
    y = kind(floats=[1.5, -0.0, float("nan")], a_int64=2**62 - 1, a_bool=False)
    same, other = x.SerializeToString(), y.SerializeToString()
    found = ColumnComparison(kind, FieldRules(FieldPatterns(()), ())).compare(
        [same] * 9, [same] * 4 + [other] * 5
    )
    assert (found.unread, found.identical) == ([], 4)
    counts = {name: (f.differences, f.largest, f.first) for name, f in found.fields.items()}
    assert counts == {"floats": (10, 0.5, 4), "a_int64": (5, 1.0, 4), "a_bool": (5, None, 4)}


def test_an_empty_batch_and_empty_messages():
    kind = protobuf_class(odd_stream())
    assert kind is not None
    columns = wire_columns.WireReader(kind, lambda _: False).read([b""] * 5)
    assert columns.known.all()
    assert not columns.numbers
    assert not np.any(wire_columns.WireReader(kind, lambda _: False).read([]).known)
