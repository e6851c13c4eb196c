"""A log with other messages on one topic is otherwise the same."""

from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from reflexarc_logs.container.first_look import look
from reflexarc_logs.diffing.message_file import MessageFile, Stream, StreamMessage
from reflexarc_logs.nodes.recorded_anew import record_anew
from support.scan_bags import scans, write_bag

JSON = Stream("/out", "", "json", "", b"")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A log with two channels of one topic, metadata and attachments."""
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=64)
        writer.start("someone", "a library")
        writer.add_metadata("who", {"a": "b"})
        schema = writer.register_schema("thing", "jsonschema", b"{}")
        out, more = (writer.register_channel("/out", "json", schema, {"q": w}) for w in "ab")
        other = writer.register_channel("/in", "json", 0, {"q": "c"})
        for k in range(20):
            writer.add_message(other, 100 * k, b"%d" % k, 100 * k - 3 * (k > 0), k + 5)
            writer.add_message(more if k % 3 else out, 100 * k + 40, b'"old"', 7, k)
        writer.add_attachment(5, 6, "map", "text/plain", b"a hall")
        writer.finish()
    return path


def said(*times_ns: int) -> list[StreamMessage]:
    return [StreamMessage(JSON, 0, at, at, b'"new %d"' % at) for at in times_ns]


def content(path: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for message in MessageFile(path).messages():
        row = message.sequence, message.log_ns, message.publish_ns, message.payload
        found.setdefault(message.stream.topic, []).append(row)
    return found


def test_one_topic_is_new_and_all_else_as_it_was(log: Path) -> None:
    before, head = content(log), look(log)
    record_anew(log, "/out", said(0, 300, 300, 1900, 5000))
    after, now = content(log), look(log)
    assert after["/in"] == before["/in"]
    assert [(row[0], row[3]) for row in after["/out"]] == [
        (0, b'"new 0"'),
        (1, b'"new 300"'),
        (2, b'"new 300"'),
        (3, b'"new 1900"'),
        (4, b'"new 5000"'),
    ]
    assert set(after) == {"/in", "/out"}
    assert (now.profile, now.metadata) == (head.profile, head.metadata)
    assert dict(now.attachments) == {"map": b"a hall"}
    assert (now.places["map"].created_ns, now.places["map"].log_ns) == (5, 6)
    assert now.complete
    assert list(log.parent.iterdir()) == [log]


def test_its_channel_says_what_it_said_before(log: Path) -> None:
    record_anew(log, "/out", said(0))
    with log.open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()  # type: ignore[union-attr]
    assert {c.topic: c.metadata for c in channels} == {"/out": {"q": "a"}, "/in": {"q": "c"}}


def test_each_message_stands_behind_the_one_that_led_to_it(log: Path) -> None:
    record_anew(log, "/out", said(0, 300))
    order = [(m.stream.topic, m.log_ns) for m in MessageFile(log).messages()]
    assert order[:3] == [("/in", 0), ("/out", 0), ("/in", 100)]
    assert order[4:6] == [("/in", 300), ("/out", 300)]


def test_a_link_stays_one_and_its_mode_stays(log: Path, tmp_path: Path) -> None:
    store = tmp_path / "store"
    store.mkdir()
    real = log.rename(store / "y.mcap")
    real.chmod(0o640)
    log.symlink_to(real)
    record_anew(log, "/out", said(0))
    assert log.is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640
    assert len(content(real)["/out"]) == 1


def test_a_failure_leaves_the_log_as_it_was(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = log.read_bytes()
    monkeypatch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "disk full")))
    with pytest.raises(OSError, match="disk full"):
        record_anew(log, "/out", said(0))
    assert log.read_bytes() == before
    assert list(log.parent.iterdir()) == [log]


def test_a_bag_is_still_one_that_rosbags_reads(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Reader

    bag = write_bag(tmp_path / "bag", scans(5), lambda scan: (0.1, 0.2))
    stream = next(m.stream for m in MessageFile(bag).messages() if m.stream.topic == "/cmd_vel")
    recorded = [m for m in MessageFile(bag).messages() if m.stream == stream]
    record_anew(bag, "/cmd_vel", [m._replace(log_ns=m.log_ns - 9) for m in recorded])
    with Reader(tmp_path / "bag") as reader:
        rows = [(c.topic, at) for c, at, _ in reader.messages()]
    assert sum(topic == "/cmd_vel" for topic, _ in rows) == 5
    assert sum(topic == "/scan" for topic, _ in rows) == 5
