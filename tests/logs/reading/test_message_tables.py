"""Tables of messages against the same messages one by one."""

from pathlib import Path

import pytest
from mcap.writer import CompressionType, Writer

from reflexarc_logs.container.record_stream import stream_records, whole_parts
from reflexarc_logs.reading import message_tables
from reflexarc_logs.reading.channels import Channels
from reflexarc_logs.reading.message_tables import tables_of
from reflexarc_logs.reading.reader import Log, Record, read_log
from reflexarc_runtime.errors import LogError

GOLDEN = sorted((Path(__file__).parents[2] / "golden").rglob("*.mcap"))


def from_tables(log: Log) -> list[Record]:
    return [table.record(row) for table in log.tables() for row in range(len(table))]


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: f"{path.parent.name}-{path.stem}")
@pytest.mark.parametrize("size", [1, 2000, 1 << 20])
def test_a_log_holds_the_same_either_way(
    path: Path, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(message_tables, "TABLE_BYTES", size)
    log = read_log(path)
    assert from_tables(log) == [*log.records()]


def written(path: Path, *, chunked: bool, unknown: bool = False) -> Path:
    """Two channels, of which the second one is defined in the middle."""
    with path.open("wb") as file:
        writer = Writer(
            file, chunk_size=300, use_chunking=chunked, compression=CompressionType.ZSTD
        )
        writer.start()
        schema = writer.register_schema("x.Y", "protobuf", b"")
        first = writer.register_channel("/a", "protobuf", schema)
        for k in range(20):
            if k == 7:
                second = writer.register_channel(
                    "/b", "protobuf", schema, {"reflexarc.sender": "01"}
                )
            channel = 9 if unknown and k == 15 else first if k < 8 or k % 3 else second
            writer.add_message(channel, 1000 + k, bytes([k]) * k, 900 + k, k)
        writer.finish()
    return path


def tables(path: Path):
    size = path.stat().st_size
    return tables_of(whole_parts(path, size, size), Channels(path))


@pytest.mark.parametrize("chunked", [True, False])
def test_channels_may_be_defined_anywhere(tmp_path: Path, chunked: bool) -> None:
    path = written(tmp_path / "a.mcap", chunked=chunked)
    found = [table.record(row) for table in tables(path) for row in range(len(table))]
    assert [record.sequence for record in found] == [*range(20)]
    assert [record.payload for record in found] == [bytes([k]) * k for k in range(20)]
    topics = ["/a" if k < 8 or k % 3 else "/b" for k in range(20)]
    assert [record.topic for record in found] == topics
    assert all(record.sender[0] == (record.topic == "/b") for record in found)


def test_a_message_of_an_unknown_channel_ends_it_behind_those_before(tmp_path: Path) -> None:
    path = written(tmp_path / "a.mcap", chunked=False, unknown=True)
    read = tables(path)
    assert next(read).heads["sequence"].tolist() == [*range(7)]  # up to the second channel
    assert next(read).heads["sequence"].tolist() == [*range(7, 15)]
    with pytest.raises(LogError, match="unknown channel"):
        next(read)


def test_counts_are_those_of_the_channels(tmp_path: Path) -> None:
    path = written(tmp_path / "a.mcap", chunked=True)
    counts: dict[str, int] = {}
    for table in tables(path):
        for channel, count in table.counted.items():
            topic = table.streams[channel].topic
            counts[topic] = counts.get(topic, 0) + count
    assert counts == {"/a": 16, "/b": 4}
    assert any(type(one.record).__name__ == "Chunk" for one in stream_records(path))
