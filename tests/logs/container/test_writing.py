"""What the writer writes, compared with the MCAP library's own writer and read by its readers."""

import zlib
from collections.abc import Callable
from pathlib import Path

import zstandard
from foxglove_schemas_protobuf.Log_pb2 import Log
from mcap.reader import make_reader
from mcap.records import Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from reflexarc_logs.container.packing.compression import (
    QUICK_LEVEL,
    THOROUGH_LEVEL,
    Compressor,
    FixedCompressor,
    ThriftyCompressor,
)
from reflexarc_logs.container.writing import PROFILE, LogWriter

CHUNK_BYTES = 500
TOPICS = ("/a", "/b", "/c")
SCHEMA = Schema(0, b"a schema", "jsonschema", "thing")


def entry(number: int) -> tuple[int, bytes, int, int]:
    """Channel, payload, publish and log time; late ones among them, and empty payloads."""
    log_ns = 1_000_000 * number - 2_500_000 * (number % 7 == 3)
    return 1 + number % 3, bytes(range(number % 60)), max(0, log_ns - 77), max(0, log_ns)


def write_ours(path: Path, count: int, compressor: Compressor, flush_every: int = 40) -> None:
    file = LogWriter(path, chunk_bytes=CHUNK_BYTES, compressor=compressor)
    file.describe("about", {"who": "me"})
    file.attach("config.json", "application/json", b"{}")
    file.flush()
    channels = [file.raw_channel(topic, "json", SCHEMA, {"m": topic}) for topic in TOPICS[:2]]
    channels.append(file.raw_channel(TOPICS[2], "", None))
    for number in range(count):
        channel, payload, publish_ns, log_ns = entry(number)
        assert channels[channel - 1] == channel
        file.add(channel, payload, sequence=number, publish_ns=publish_ns, log_ns=log_ns)
        if number % flush_every == flush_every - 1:
            file.flush()
    file.describe("end", {"missing": "3"})
    file.finish()


def write_theirs(path: Path, count: int, flush_every: int = 40) -> None:
    with path.open("xb") as stream:
        file = Writer(
            stream,
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        file.start(profile=PROFILE)
        file.add_metadata("about", {"who": "me"})
        file.add_attachment(0, 0, "config.json", "application/json", b"{}")
        file.flush()  # type: ignore[no-untyped-call]  # mcap has no type for it
        number_of = file.register_schema(SCHEMA.name, SCHEMA.encoding, SCHEMA.data)
        for topic in TOPICS[:2]:
            file.register_channel(topic, "json", number_of, {"m": topic})
        file.register_channel(TOPICS[2], "", 0)
        for number in range(count):
            channel, payload, publish_ns, log_ns = entry(number)
            file.add_message(channel, log_ns, payload, publish_ns, number)
            if number % flush_every == flush_every - 1:
                file.flush()  # type: ignore[no-untyped-call]
        file.add_metadata("end", {"missing": "3"})
        file.finish()  # type: ignore[no-untyped-call]


def test_the_same_messages_give_the_bytes_of_the_librarys_writer(tmp_path: Path):
    ours, theirs = tmp_path / "ours.mcap", tmp_path / "theirs.mcap"
    write_ours(ours, 333, FixedCompressor(QUICK_LEVEL))
    write_theirs(theirs, 333)
    assert ours.read_bytes() == theirs.read_bytes()


def test_thorough_chunks_are_read_by_the_librarys_readers(tmp_path: Path):
    path = tmp_path / "log.mcap"
    write_ours(path, 333, FixedCompressor())
    sent = [entry(number) for number in range(333)]
    with path.open("rb") as stream:
        records = list(StreamReader(stream, validate_crcs=True).records)
        got = [
            (r.channel_id, r.data, r.publish_time, r.log_time)
            for r in records
            if type(r).__name__ == "Message"
        ]
        assert got == sent
        stream.seek(0)
        reader = make_reader(stream, validate_crcs=True)
        found = [
            (channel.id, message.data, message.publish_time, message.log_time)
            for _, channel, message in reader.iter_messages(topics=["/b"])
        ]
        assert found == sorted((s for s in sent if s[0] == 2), key=lambda s: s[3])
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.channel_message_counts == {1: 111, 2: 111, 3: 111}
        since = [m.log_time for _, _, m in reader.iter_messages(starting_at=200_000_000)]
        assert since == sorted(s[3] for s in sent if s[3] >= 200_000_000)


def test_a_log_that_nothing_was_written_to_is_whole(tmp_path: Path):
    path = tmp_path / "log.mcap"
    LogWriter(path).finish()
    with path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == 0


def test_what_was_flushed_is_in_the_file_and_whole(tmp_path: Path):
    file = LogWriter(tmp_path / "log.mcap")
    channel = file.channel("/log", Log)
    for number in range(5):
        file.add(channel, b"x" * number, sequence=number, publish_ns=0, log_ns=number)
    file.flush()
    file.add(channel, b"lost", sequence=9, publish_ns=0, log_ns=9)
    [held] = _chunks(file.file.partial.read_bytes())
    assert held.endswith(b"xxxx")
    assert b"lost" not in held
    file.discard()


def _chunks(data: bytes) -> list[bytes]:
    """What the chunks of unfinished bytes hold: a walk over their records by hand."""
    at, found = 8, []
    while at < len(data):
        kind, size = data[at], int.from_bytes(data[at + 1 : at + 9], "little")
        fields = data[at + 9 : at + 9 + size]
        assert len(fields) == size
        if kind == 6:  # first and last time, size, CRC, name of the compression, size again
            unpacked = zstandard.decompress(fields[28 + 4 + 4 + 8 :])
            assert fields[28 + 4 : 28 + 8] == b"zstd"
            assert len(unpacked) == int.from_bytes(fields[16:24], "little")
            assert zlib.crc32(unpacked) == int.from_bytes(fields[24:28], "little")
            found.append(unpacked)
        at += 9 + size
    return found


class Clock:
    """A time that the test sets."""

    def __init__(self) -> None:
        self.now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


def level_of(compressed: bytes, data: bytes) -> int:
    """Which of the two levels made these bytes."""
    made: dict[bytes, int] = {
        zstandard.ZstdCompressor(level=level).compress(data): level
        for level in (THOROUGH_LEVEL, QUICK_LEVEL)
    }
    assert len(made) == 2
    return made[compressed]


def taking(clock: Clock, took_s: float) -> Callable[[FixedCompressor, bytes], bytes]:
    """A compression that takes so long."""
    zstd = FixedCompressor.compress

    def compress(self: FixedCompressor, data: bytes) -> bytes:
        clock.now_s += took_s
        return zstd(self, data)

    return compress


def levels(clock: Clock, pause_s: float, count: int) -> list[int]:
    """The levels of chunks that come so long one after the other."""
    data = b"".join(bytes([k % 251, k * k % 241, k % 7, 9]) for k in range(300))
    compressor, found = ThriftyCompressor(clock), []
    for _ in range(count):
        found.append(level_of(compressor.compress(data), data))
        clock.now_s += pause_s
    return found


def test_chunks_are_compressed_thoroughly_while_that_takes_little_of_the_time(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(FixedCompressor, "compress", taking(clock, 0.01))
    assert set(levels(clock, 0.6, 500)) == {THOROUGH_LEVEL}


def test_where_compression_would_take_a_core_most_chunks_are_compressed_quickly(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(FixedCompressor, "compress", taking(clock, 0.01))
    found = levels(clock, 0.01, 500)
    assert found[:10] == [THOROUGH_LEVEL] * 10  # a tenth of a second that was saved
    assert 0.03 < found[20:].count(THOROUGH_LEVEL) / 480 < 0.05  # a fiftieth of 20 ms is 0.4 of 10


def test_thorough_chunks_take_a_fiftieth_of_the_time_and_no_more(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(FixedCompressor, "compress", taking(clock, 0.001))
    found = levels(clock, 0.03, 600)
    share = found[300:].count(THOROUGH_LEVEL) / 300
    assert 0.5 < share < 0.75  # a fiftieth of 31 ms is 0.62
