from dataclasses import replace
from pathlib import Path

from reflexarc_logs.reading.summary import LogSummary, summarise
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo, encode_body
from reflexarc_runtime.messages.codec import Status, encode_status
from reflexarc_runtime.messages.topics import BODY_NODE, RUNTIME_NODE
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.recordings import RUN

GOLDEN = Path(__file__).parents[2] / "golden"
INFO = BodyInfo("w", 'name = "w"', 7, 1, 0.02, BodyLimits(1.0, 1.0, 0.0))


def said(payload: bytes, number: int, sender: bytes = b"a" * 16) -> Message:
    stamp = pack_stamp(Stamp(number, number, sender))
    return Message("robot0/body", payload, protobuf_encoding("reflexarc.Body"), stamp, number)


def summary_of(path: Path, *messages: Message) -> LogSummary:
    with Recorder(path, replace(RUN), b"", {}, wall_offset_ns=0) as recorder:
        for message in messages:
            recorder.put(message)
    return summarise(path)


def test_where_the_body_was_is_what_its_last_message_says(tmp_path: Path):
    before = encode_body(replace(INFO, step_s=0.1))  # built for the runtime before this one
    summary = summary_of(tmp_path / "a.mcap", said(before, 0), said(encode_body(INFO), 1))
    assert summary.body == INFO


def test_a_log_without_a_body_says_nothing_of_a_world(tmp_path: Path):
    assert summary_of(tmp_path / "a.mcap").body is None
    assert summarise(GOLDEN / "nominal.mcap").body is None
    unreadable = said(b"\xff", 0)
    assert summary_of(tmp_path / "b.mcap", unreadable).body is None


def test_what_the_runtime_says_of_its_watchdog_is_told_and_not_what_a_body_says(tmp_path: Path):
    statuses = [
        Status(BODY_NODE, watchdog="a body has none"),
        Status(RUNTIME_NODE, watchdog="on, 50 ms"),
        Status(RUNTIME_NODE, watchdog="the loop is late: 90 ms"),
    ]
    messages = [
        replace(
            said(encode_status(status), number),
            key="robot0/status",
            encoding=protobuf_encoding("reflexarc.Status"),
        )
        for number, status in enumerate(statuses)
    ]
    assert summary_of(tmp_path / "a.mcap", *messages).watchdog == "on, 50 ms"
    assert summary_of(tmp_path / "b.mcap", messages[0]).watchdog == ""


def test_the_settings_of_the_guard_are_those_of_the_run(tmp_path: Path):
    guard = GuardSettings(0.07, Footprint(radius_m=0.2))
    with Recorder(
        tmp_path / "a.mcap", replace(RUN, guard=guard.to_json()), b"", {}, wall_offset_ns=0
    ):
        pass
    assert summarise(tmp_path / "a.mcap").guard == guard
    assert summary_of(tmp_path / "b.mcap").guard is None


def test_the_senders_of_a_topic_are_counted(tmp_path: Path):
    payload = encode_body(INFO)
    messages = [said(payload, number, bytes([65 + number % 2] * 16)) for number in range(6)]
    (topic,) = summary_of(tmp_path / "a.mcap", *messages).topics
    assert (topic.topic, topic.messages, topic.senders) == ("/robot0/body", 6, 2)


def test_an_older_log_says_no_senders():
    old = summarise(GOLDEN / "museum" / "schema-2" / "drive.mcap")
    assert {topic.senders for topic in old.topics} == {0}
