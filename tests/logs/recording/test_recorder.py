import errno
import logging
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.timestamp_pb2 import Timestamp
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from reflexarc_logs.container import unfinished
from reflexarc_logs.container.rejected import KEPT_BYTES
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording.backlog import Backlog
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import (
    MAX_PAYLOAD_BYTES,
    Message,
    Stamp,
    pack_stamp,
    protobuf_encoding,
)
from reflexarc_runtime.messages_pb2 import Rejected, Tick
from support.recordings import ENCODING, KEY, MS, RUN, WALL_OFFSET_NS, drive, nominal, retina_at

GOOD = retina_at(1, np.zeros((1, 16, 1), np.uint8))


def record(path: Path, messages: list[Message], run: RunInfo = RUN) -> Recorder:
    with Recorder(path, run, b"", {}, wall_offset_ns=WALL_OFFSET_NS) as recorder:
        for message in messages:
            recorder.put(message)
    return recorder


payloads = st.one_of(st.binary(max_size=200), st.just(GOOD.payload))
stamps = st.builds(
    lambda sequence, time_ns: pack_stamp(Stamp(sequence, time_ns)),
    st.integers(-(2**63), 2**63 - 1) | st.integers(0, 2**32 - 1),
    st.integers(-(2**63), 2**63 - 1),
)
messages = st.builds(
    Message,
    key=st.just(KEY),
    payload=payloads,
    encoding=st.sampled_from([ENCODING, ENCODING, "application/json", ""]),
    attachment=stamps | st.binary(max_size=40),
    received_ns=st.integers(0, 2**62),
)


@settings(max_examples=60, deadline=None)
@given(batch=st.lists(messages, max_size=12))
def test_whatever_arrives_comes_back_from_the_log_as_it_was_and_in_its_order(
    batch, tmp_path_factory
):
    path = tmp_path_factory.mktemp("round-trip") / "log.mcap"
    assert record(path, batch).state == "off"
    assert list(loop_events(read_log(path))) == batch


def test_a_batch_stands_before_its_tick_and_the_tick_before_its_command(log_path):
    topics = [record.topic.rpartition("/")[2] for record in read_log(log_path).records()]
    second = ["retina", "tick", "command"] * 50
    rest = ["retina", "tick", "command"] * 10
    assert topics == ["keyframe", *second, "keyframe", *rest, "stop", "tick", "command"]


def test_log_time_is_the_arrival_on_the_wall_clock_and_publish_time_the_sender_s(log_path):
    for record in read_log(log_path).records("/robot0/tick"):
        decision = Tick.FromString(record.payload).decision
        assert record.log_ns == decision.now_ns + WALL_OFFSET_NS
        assert (record.sequence, record.publish_ns) == (decision.index, decision.now_ns)


def test_the_log_opens_in_the_ordinary_mcap_reader_with_its_schemas(log_path):
    with log_path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        found = {(s.name, c.topic) for s, c, _ in reader.iter_messages() if s is not None}
        names = [attachment.name for attachment in reader.iter_attachments()]
    assert found == {
        ("foxglove.RawImage", "/robot0/retina"),
        ("reflexarc.Tick", "/robot0/tick"),
        ("reflexarc.Command", "/robot0/command"),
        ("reflexarc.Keyframe", "/robot0/keyframe"),
        ("reflexarc.Stop", "/robot0/stop"),
    }
    assert names == ["policy.onnx", "config.json"]


def test_the_log_says_whose_run_it_is_and_carries_policy_and_configuration(log_path, policy):
    log = read_log(log_path)
    assert log.policy == policy
    assert b'"rate_hz": 50.0' in (log.config or b"")
    assert log.run.run_id == RUN.run_id
    assert log.run.wall_offset_ns == WALL_OFFSET_NS
    assert len(log.run.policy_hash) == 64


REJECTED = {
    "broken protobuf": (replace(GOOD, payload=b"\xff\xff"), "payload: no foxglove.RawImage"),
    "another encoding": (replace(GOOD, encoding="text/plain"), "encoding: expected"),
    "no attachment": (replace(GOOD, attachment=b""), "attachment: expected 33 bytes"),
    "a key of another robot": (replace(GOOD, key="robot1/retina"), "key: not one"),
    "a key that nobody knows": (replace(GOOD, key="robot0/nonsense"), "key: not one"),
    "a forged rejection": (
        replace(GOOD, key="robot0/rejected", encoding=protobuf_encoding("reflexarc.Rejected")),
        "key: not one",
    ),
}


@pytest.mark.parametrize("case", REJECTED)
def test_what_cannot_be_decoded_goes_on_the_rejected_channel(case, tmp_path):
    message, reason = REJECTED[case]
    record(tmp_path / "log.mcap", [message])
    ((entry, rejected),) = read_log(tmp_path / "log.mcap").messages("/robot0/rejected", Rejected)
    assert rejected.reason.startswith(reason)
    assert (rejected.key, rejected.encoding) == (message.key, message.encoding)
    assert (rejected.payload, rejected.attachment) == (message.payload, message.attachment)
    assert entry.log_ns == message.received_ns + WALL_OFFSET_NS


def test_a_huge_payload_is_kept_in_part_and_its_true_size_in_full(tmp_path):
    huge = replace(GOOD, payload=b"\x01" * (MAX_PAYLOAD_BYTES + 5))
    record(tmp_path / "log.mcap", [huge])
    log = read_log(tmp_path / "log.mcap")
    ((_, rejected),) = log.messages("/robot0/rejected", Rejected)
    assert (len(rejected.payload), rejected.payload_bytes) == (KEPT_BYTES, len(huge.payload))
    (back,) = loop_events(log)
    assert len(back.payload) == MAX_PAYLOAD_BYTES + 1


def test_a_message_that_decodes_and_does_not_fit_stays_on_its_channel(tmp_path):
    record(tmp_path / "log.mcap", [replace(GOOD, payload=b"")])
    assert [r.topic for r in read_log(tmp_path / "log.mcap").records()] == ["/robot0/retina"]


def test_an_existing_log_is_never_overwritten(tmp_path):
    path = tmp_path / "log.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(LogError, match=r"exists already; choose another name or remove it$"):
        record(path, [])
    assert path.read_bytes() == b"precious"
    assert [p.name for p in tmp_path.iterdir()] == ["log.mcap"]


def test_an_unfinished_recording_is_never_overwritten(tmp_path):
    (tmp_path / "log.mcap.partial").write_bytes(b"precious")
    with pytest.raises(LogError, match="an unfinished log is there"):
        record(tmp_path / "log.mcap", [])


@pytest.mark.parametrize("place", ["missing/log.mcap", "file/log.mcap", "n" * 300])
def test_a_place_that_cannot_be_written_is_refused_in_one_line(place, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(LogError, match=r"cannot be written: .*; choose another place$") as caught:
        record(tmp_path / place, [])
    assert "\n" not in str(caught.value)


class FullDisk:
    """A file on a disk with room for so many bytes."""

    def __init__(self, path: Path, room: int) -> None:
        self._file, self._room = path.open("xb"), room

    def write(self, data: bytes) -> int:
        fitting = data[: max(0, self._room - self._file.tell())]
        self._file.write(fitting)
        if len(fitting) < len(data):
            raise OSError(errno.ENOSPC, "No space left on device")
        return len(data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def noise(count: int) -> list[Message]:
    """Retina messages that do not compress: data of 1 KiB, of the wrong size on purpose."""
    rng = np.random.default_rng(0)
    body = [b"\x3a\x80\x08" + rng.bytes(1024) for _ in range(count)]
    return [
        replace(GOOD, payload=payload, attachment=pack_stamp(Stamp(i, i)), received_ns=i)
        for i, payload in enumerate(body)
    ]


def test_a_full_disk_stops_the_recording_says_so_once_and_keeps_what_was_written(
    tmp_path, monkeypatch, caplog
):
    monkeypatch.setattr(unfinished, "open_for_writing", lambda path: FullDisk(path, 300_000))
    with caplog.at_level(logging.ERROR):
        recorder = record(tmp_path / "log.mcap", noise(2000))
    assert recorder.state == "stopped: No space left on device"
    assert len(caplog.records) == 1
    assert "the robot goes on" in caplog.text
    recorder.put(GOOD)  # the robot goes on
    assert [p.name for p in tmp_path.iterdir()] == ["log.mcap.partial"]
    log = read_log(tmp_path / "log.mcap.partial", allow_truncated=True)
    sequences = [r.sequence for r in log.records()]
    assert len(sequences) > 100
    assert sequences == list(range(len(sequences)))


def test_a_disk_that_is_full_from_the_start_is_refused_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(unfinished, "open_for_writing", lambda path: FullDisk(path, 100))
    with pytest.raises(LogError, match="cannot be written: No space left on device"):
        record(tmp_path / "log.mcap", [])
    assert not list(tmp_path.iterdir())


def test_a_configuration_that_is_no_json_is_our_mistake_and_leaves_nothing(tmp_path):
    with pytest.raises(TypeError):
        Recorder(tmp_path / "log.mcap", RUN, b"", {"no": object()}, wall_offset_ns=0)
    assert not list(tmp_path.iterdir())


def test_the_node_drives_on_when_its_recording_stops(tmp_path, monkeypatch, policy, caplog):
    monkeypatch.setattr(unfinished, "open_for_writing", lambda path: FullDisk(path, 8_000))
    verdicts = drive(tmp_path / "log.mcap", policy, nominal(300), 300)
    assert verdicts["OK"] == 298
    assert "the recording stopped" in caplog.text


def test_a_backlog_that_is_full_drops_and_counts_by_records_and_by_bytes():
    few, small = Backlog(max_records=3), Backlog(max_bytes=3 * len(GOOD.payload))
    for _ in range(5):
        few.put(GOOD)
        small.put(GOOD)
    assert (few.dropped, small.dropped) == (2, 2)
    assert [few.take(0.0), few.take(0.0)] == [GOOD, GOOD]
    small.take(0.0)
    few.put(GOOD)
    small.put(GOOD)
    assert (few.dropped, small.dropped) == (2, 2)


def test_a_log_with_dropped_records_says_how_many_and_so_does_the_state(tmp_path, monkeypatch):
    monkeypatch.setattr("reflexarc_logs.recording.recorder.Backlog", lambda: Backlog(max_records=0))
    recorder = record(tmp_path / "log.mcap", [GOOD] * 7)
    assert recorder.state == "off, 7 records dropped"
    assert read_log(tmp_path / "log.mcap").dropped == 7


def test_a_wall_clock_before_the_boot_gives_no_negative_time(tmp_path):
    with Recorder(tmp_path / "log.mcap", RUN, b"", {}, wall_offset_ns=-5) as recorder:
        recorder.put(GOOD)
    log = read_log(tmp_path / "log.mcap")
    assert log.run.wall_offset_ns == 0
    assert [r.log_ns for r in log.records()] == [GOOD.received_ns]


def test_closing_twice_is_closing_once_and_nothing_is_taken_afterwards(tmp_path):
    recorder = record(tmp_path / "log.mcap", [GOOD])
    recorder.put(GOOD)
    recorder.close()
    assert len(list(read_log(tmp_path / "log.mcap").records())) == 1


def test_streams_of_the_body_are_recorded_beside_the_loop_s(tmp_path, policy):
    stamp = Timestamp(seconds=1).SerializeToString()
    pose = Message(
        "robot0/pose",
        b"\x0a" + bytes([len(stamp)]) + stamp,
        protobuf_encoding("foxglove.PoseInFrame"),
        GOOD.attachment,
        GOOD.received_ns,
    )
    drive(tmp_path / "log.mcap", policy, nominal(5), 5, before=[pose], after=[pose])
    topics = [r.topic for r in read_log(tmp_path / "log.mcap").records()]
    assert topics.count("/robot0/pose") == 2


def test_viewers_show_both_times_of_a_message_together(log_path):
    """In the file both are on the wall clock; the payload's own stamp stays as it was sent."""
    log = read_log(log_path)
    sent = {(r.topic, r.sequence): r.publish_ns for r in log.records()}
    with log_path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            sent_ns = sent[channel.topic, message.sequence]
            assert message.publish_time == sent_ns + WALL_OFFSET_NS
            assert abs(message.log_time - message.publish_time) <= 4 * MS  # sent, then taken
            if channel.topic == "/robot0/retina":
                image = RawImage.FromString(message.data)
                assert image.timestamp.ToNanoseconds() == sent_ns
