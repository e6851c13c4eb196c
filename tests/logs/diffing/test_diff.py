"""Two logs of anybody: what is missing, what differs, by how much."""

import json
import random
import struct
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from google.protobuf.json_format import MessageToDict
from mcap.reader import NonSeekingReader

from reflexarc_logs.container.writing import LogWriter
from reflexarc_logs.diffing.diff import diff
from reflexarc_logs.diffing.diff_report import DiffReport, TopicDiff
from reflexarc_logs.diffing.diff_rules import DiffRules, Tolerance, read_rules
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.messages_pb2 import Tick
from support.foreign_logs import json_log, one_message
from support.processes import reflexarc

GOLDEN = Path(__file__).parents[2] / "golden"
Write = Callable[..., Path]


def only(report: DiffReport) -> TopicDiff:
    (topic,) = report.topics
    return topic


def test_a_file_is_the_same_as_itself():
    report = diff(GOLDEN / "nominal.mcap", GOLDEN / "nominal.mcap")
    assert report.exit_status == 0
    with (GOLDEN / "nominal.mcap").open("rb") as file:
        counts = Counter(c.topic for _, c, _ in NonSeekingReader(file).iter_messages())
    assert {t.topic: t.identical for t in report.topics} == counts


def test_a_missing_message_shifts_nothing(write: Write):
    rows = [(i, 10 * i, {"x": i}) for i in range(50)]
    report = diff(write("a", s=rows), write("b", s=rows[:20] + rows[21:]))
    topic = only(report)
    assert (topic.align, topic.paired, topic.identical) == ("sequence", 49, 49)
    assert (topic.only_a, topic.only_b, report.exit_status) == (1, 0, 1)
    assert topic.first_only_a is not None
    assert topic.first_only_a.sequence == 20


def test_without_sequence_numbers_the_time_of_sending_pairs(write: Write):
    rows = [(0, 10 * i, {"x": i}) for i in range(50)]
    topic = only(diff(write("a", s=rows), write("b", s=rows[:20] + rows[21:])))
    assert (topic.align, topic.identical, topic.only_a) == ("publish-time", 49, 1)


def test_two_drives_without_sequence_numbers_are_paired_in_order(write: Write):
    rows = [(0, 10 * i, {"x": i}) for i in range(50)]
    other = [(0, 10 * i + 5, {"x": i}) for i in range(50)]
    topic = only(diff(write("a", s=rows), write("b", s=other)))
    assert (topic.align, topic.identical) == ("order", 50)


def test_a_restarted_counter_is_no_counter(write: Write):
    rows = [(i % 10, 10 * i, {"x": i}) for i in range(50)]
    topic = only(diff(write("a", s=rows), write("b", s=rows)))
    assert (topic.align, topic.identical) == ("publish-time", 50)


def test_counters_that_never_meet_pair_nothing_and_are_left(write: Write):
    a = [(i, 10 * i, {"x": i}) for i in range(50)]
    b = [(1000 + i, 10 * i, {"x": i}) for i in range(50)]
    assert only(diff(write("a", s=a), write("b", s=b))).identical == 50


def test_a_topic_of_one_side_only_is_missing(write: Write):
    rows = [(i, i, {"x": i}) for i in range(3)]
    report = diff(write("a", s=rows, t=rows), write("b", s=rows))
    missing = report.topics[1]
    assert (missing.topic, missing.only_a, missing.messages_b) == ("/t", 3, 0)
    assert report.exit_status == 1


def test_nothing_in_common_and_nothing_at_all(write: Write):
    assert diff(write("a"), write("b")).exit_status == 2


@pytest.mark.parametrize(
    ("a", "b", "field", "largest"),
    [
        ({"x": 1.0}, {"x": 1.25}, "x", 0.25),
        ({"x": [1, 2, 3]}, {"x": [1, 2, 5]}, "x", 2),
        ({"x": [1, 2]}, {"x": [1, 2, 3]}, "x", None),
        ({"x": 1}, {"x": True}, "x", None),
        ({"x": 0.0}, {"x": -0.0}, "x", 0.0),
        ({"x": {"y": "a"}}, {"x": {"y": "b"}}, "x.y", None),
        ({"x": None}, {}, "x", None),
        ({"x": 2**63}, {"x": 2**63 + 1}, "x", 1),
    ],
)
def test_what_differs_and_by_how_much(write: Write, a, b, field: str, largest: float | None):
    topic = only(diff(write("a", s=[(0, 0, a)]), write("b", s=[(0, 0, b)])))
    (found,) = topic.fields.values()
    assert (found.field, found.differences, found.largest) == (field, 1, largest)


def test_not_a_number_is_itself(write: Write):
    rows = [(0, 0, b'{"x": NaN}')]
    assert diff(write("a", s=rows), write("b", s=[(0, 0, b'{"x":  NaN}')])).exit_status == 0


def test_rules_pass_over_and_tolerate(write: Write, tmp_path: Path):
    a = write("a", s=[(0, 0, {"x": 1.0, "h": {"stamp": 5}})], t=[(0, 0, {"z": 1})])
    b = write("b", s=[(0, 0, {"x": 1.001, "h": {"stamp": 6}})], t=[(0, 0, {"z": 2})])
    rules = tmp_path / "rules.toml"
    rules.write_text(
        'ignore = ["/t", "*:h.stamp"]\n[[tolerate]]\nfields = "/s:x"\nabsolute = 0.01\n'
    )
    report = diff(a, b, read_rules(rules))
    assert (report.exit_status, report.ignored) == (0, ("/t",))
    stricter = DiffRules(ignore=("/t", "/s:h"), tolerate=(Tolerance("/s:x", relative=1e-4),))
    assert list(only(diff(a, b, stricter)).fields) == ["x"]


@pytest.mark.parametrize("text", ["ignore = 3", "align = 'x'", "[[tolerate]]\nabsolute = 1", "a="])
def test_rules_that_are_none(tmp_path: Path, text: str):
    path = tmp_path / "rules.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=r"rules\.toml"):
        read_rules(path)


def test_mutations_of_ticks_are_found_where_they_are(tmp_path: Path):
    """Against the reference reader and protobuf's own JSON: the same fields, the same messages."""
    draw = random.Random(7)
    expected: set[tuple[int, str]] = set()

    def mutate(tick: Tick, number: int) -> None:
        before = MessageToDict(tick.decision, preserving_proto_field_name=True)
        chosen = draw.choice(["action", "q_values", "retina", "reason"])
        if chosen == "q_values" and tick.decision.q_values:
            tick.decision.q_values[0] += draw.choice([1e-7, 1.0, -3.0])
        elif chosen == "retina" and tick.decision.retina:
            tick.decision.retina = bytes([255 - tick.decision.retina[0]]) + tick.decision.retina[1:]
        elif chosen == "action":
            tick.decision.action += 1
        else:
            tick.decision.reason += "!"
        after = MessageToDict(tick.decision, preserving_proto_field_name=True)
        changed = {k for k in {*before, *after} if before.get(k) != after.get(k)}
        expected.update((number, f"decision.{k}") for k in changed)

    other = rewritten(GOLDEN / "nominal.mcap", tmp_path / "b.mcap", mutate, draw)
    report = diff(GOLDEN / "nominal.mcap", other)
    tick = next(t for t in report.topics if t.topic == "/robot0/tick")
    assert {t.topic for t in report.topics if not t.is_same} == {"/robot0/tick"}
    assert {f: d.differences for f, d in tick.fields.items()} == Counter(f for _, f in expected)
    first = {f: d.first.number for f, d in tick.fields.items() if d.first is not None}
    assert first == {f: min(n for n, g in expected if g == f) for f in first}


def rewritten(source: Path, out: Path, mutate, draw: random.Random) -> Path:
    """A log whose ticks were changed, one in ten."""
    file, ticks = LogWriter(out), 0
    with source.open("rb") as stream:
        for schema, channel, message in NonSeekingReader(stream).iter_messages():
            data = message.data
            if schema.name == "reflexarc.Tick":
                tick = Tick.FromString(data)
                if draw.random() < 0.1:
                    mutate(tick, ticks)
                tick.timing.lateness_ns += 5  # passed over
                data, ticks = tick.SerializeToString(), ticks + 1
            where = file.raw_channel(
                channel.topic, channel.message_encoding, schema, channel.metadata
            )
            file.add(
                where,
                data,
                sequence=message.sequence,
                publish_ns=message.publish_time,
                log_ns=message.log_time,
            )
    file.finish()
    return out


def test_files_that_are_none(tmp_path: Path, write: Write):
    good, bad = write("a", s=[(0, 0, {})]), tmp_path / "b.mcap"
    bad.write_bytes(b"no log")
    with pytest.raises(LogError, match=r"b\.mcap: expected an MCAP file"):
        diff(good, bad)
    with pytest.raises(LogError, match="cannot be read"):
        diff(tmp_path / "none.mcap", good)
    bad.write_bytes(good.read_bytes()[:60])
    assert any("is cut" in note for note in diff(good, bad).notes)


def test_a_message_shorter_than_its_own_fields_is_damage(tmp_path: Path, write: Write):
    """A chunk whose last message ends in the middle of its times."""
    short = tmp_path / "short.mcap"
    channel = struct.pack("<HHI2sI4sI", 1, 0, 2, b"/s", 4, b"json", 0)
    content = b"".join(struct.pack("<BQ", k, len(d)) + d for k, d in ((4, channel), (5, bytes(9))))
    head = struct.pack("<QQQII", 0, 0, len(content), 0, 0) + struct.pack("<Q", len(content))
    records = ((1, bytes(8)), (6, head + content), (15, bytes(4)))
    body = b"".join(struct.pack("<BQ", kind, len(data)) + data for kind, data in records)
    short.write_bytes(b"\x89MCAP0\r\n" + body)
    with pytest.raises(LogError, match=r"short\.mcap: damaged: a record shorter than its own"):
        diff(write("a", s=[(0, 0, {})]), short)


def test_the_command_says_it_in_each_form(write: Write):
    a, b = write("a", s=[(0, 0, {"x": 1})]), write("b", s=[(0, 0, {"x": 3})])
    text = reflexarc("diff", a, b)
    assert text.returncode == 1
    assert "x: 1 differ, at most 2 apart" in text.stdout
    assert "first divergence: /s, message 0 (sequence 0, 0.000 s): x: 1 → 3" in text.stdout
    assert (
        "| `/s` | 1 | 1 | 1 | 0 | 0 | 0 | `x` 1 |" in reflexarc("diff", a, b, "--markdown").stdout
    )
    assert json.loads(reflexarc("diff", a, b, "--json").stdout)["exit_status"] == 1
    assert reflexarc("diff", a, a).returncode == 0
    assert reflexarc("diff", a, "none.mcap").returncode == 2


def test_the_messages_of_ros_2_are_told_apart_by_fields(tmp_path: Path):
    rosbags = pytest.importorskip("rosbags.typesys")
    store = rosbags.get_typestore(rosbags.Stores.ROS2_HUMBLE)
    kind = store.types["geometry_msgs/msg/Point"]
    schema = ("geometry_msgs/msg/Point", "ros2msg", b"float64 x\nfloat64 y\nfloat64 z\n")
    paths = [
        one_message(
            tmp_path / f"{x}.mcap",
            "cdr",
            bytes(store.serialize_cdr(kind(x=x, y=0.0, z=0.0), schema[0])),
            schema,
        )
        for x in (1.0, 1.5)
    ]
    (found,) = only(diff(*paths)).fields.values()
    assert (found.field, found.largest) == ("x", 0.5)


def test_what_nobody_can_decode_is_compared_as_bytes(tmp_path: Path):
    nothing = ("", "", b"")
    paths = [one_message(tmp_path / f"{d[1]}.mcap", "ros1", d, nothing) for d in (b"\1\2", b"\1\3")]
    topic = only(diff(*paths))
    assert list(topic.fields) == ["payload"]
    assert "compared as bytes" in topic.notes[0]


def test_a_log_in_another_order_of_topics_is_the_same(tmp_path: Path):
    rows = [(i, 10 * i, {"x": i}) for i in range(200)]
    a = json_log(tmp_path / "a.mcap", s=rows, t=rows[::10])
    b = json_log(tmp_path / "b.mcap", t=[(s, p + 3, w) for s, p, w in rows[::10]], s=rows)
    assert diff(a, b).exit_status == 0
