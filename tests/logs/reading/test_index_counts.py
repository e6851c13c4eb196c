from dataclasses import replace
from pathlib import Path

import pytest
from mcap.writer import Writer

from reflexarc_logs.reading import summary as module
from reflexarc_logs.reading.summary import ForeignSummary, LogSummary, describe_any, summarise
from reflexarc_runtime.errors import LogError
from support.rewriting import flip_bit

GOLDEN = Path(__file__).parents[2] / "golden"


@pytest.mark.parametrize("name", ["nominal", "faults", "museum/schema-2/drive"])
def test_the_index_tells_what_all_messages_tell_but_for_the_payload(name: str, monkeypatch):
    in_full = summarise(GOLDEN / f"{name}.mcap")
    monkeypatch.setattr(module, "FULLY_READ_BYTES", 0)
    by_index = summarise(GOLDEN / f"{name}.mcap")
    assert by_index.by_index
    assert not in_full.by_index
    topics = tuple(replace(topic, payload_bytes=None) for topic in in_full.topics)
    assert by_index == replace(in_full, topics=topics, by_index=True)


def test_a_cut_or_damaged_log_is_not_taken_for_whole_by_its_index(
    log_path: Path, tmp_path: Path, monkeypatch
):
    monkeypatch.setattr(module, "FULLY_READ_BYTES", 0)
    data, path = log_path.read_bytes(), tmp_path / "log.mcap"
    path.write_bytes(data[:-40])
    cut = describe_any(path)
    assert isinstance(cut, LogSummary)
    assert not cut.complete
    assert not cut.by_index
    path.write_bytes(flip_bit(data, len(data) // 3))
    with pytest.raises(LogError, match="damaged"):
        describe_any(path)


@pytest.mark.parametrize("threshold", [0, 1 << 20])
def test_a_log_of_another_system_is_described(threshold: int, tmp_path: Path, monkeypatch):
    monkeypatch.setattr(module, "FULLY_READ_BYTES", threshold)
    path = tmp_path / "bag.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        channels = [writer.register_channel(name, "cdr", schema) for name in ("/b", "/a", "/b")]
        for number in range(30):
            writer.add_message(channels[number % 3], 10**9 + number * 10**8, b"x" * 7, 0)
        writer.add_metadata("rosbag2", {"a": "b"})
        writer.finish()  # type: ignore[no-untyped-call]  # mcap has no type for it
    found = describe_any(path)
    assert isinstance(found, ForeignSummary)
    counts = {t.topic: (t.schema, t.messages, t.payload_bytes) for t in found.topics}
    payload = (140, 70) if threshold else (None, None)
    name = "std_msgs/msg/String"
    assert counts == {"/a": (name, 10, payload[1]), "/b": (name, 20, payload[0])}
    assert (found.profile, found.metadata, found.messages) == ("ros2", ("rosbag2",), 30)
    assert found.first_ns == 10**9
    assert found.duration_s == pytest.approx(2.9)
