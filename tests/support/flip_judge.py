"""Whether a replay of a damaged log told the truth, by an account of its own of what was damaged.

The damaged log is read by the plain MCAP library without any check, and compared with the whole one
record by record. Three things are wrong: `different` where something is missing and nothing was
changed; `identical` where something that is compared was changed and nothing says that it was left
out; `identical` where ticks are missing and nothing says so.
"""

import random
import struct
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages_pb2 import Command, Decision, Tick

MAGIC = b"\x89MCAP0\r\n"
MESSAGE_INDEX = 7


class Row(NamedTuple):
    """A record of a log, with its place in it: topic, numbers, payload."""

    topic: str
    sequence: int
    log_ns: int
    publish_ns: int
    payload: bytes


@dataclass(frozen=True)
class Contents:
    """All that a log holds."""

    rows: Counter[Row]
    """Messages; of ticks only the decision."""
    head: Counter[Row]
    """Attachments, metadata, schemas and channels: what says how the messages are to be read."""


def contents(path: Path) -> Contents:
    """All that the plain library reads of a log, until it reads no more."""
    rows: Counter[Row] = Counter()
    head: Counter[Row] = Counter()
    topics: dict[int, str] = {}
    for record in _records(path):
        if isinstance(record, Message):
            topic = topics.get(record.channel_id, "?")
            rows[_row(topic, record)] += 1
        elif isinstance(record, Channel):
            topics[record.id] = record.topic
            head[Row("channel", record.id, 0, 0, repr(record).encode())] = 1
        elif isinstance(record, Schema | Metadata | Attachment):
            head[Row(type(record).__name__, 0, 0, 0, repr(record).encode())] = 1
    return Contents(rows, head)


def _records(path: Path) -> Iterator[McapRecord]:
    with path.open("rb") as file, suppress(McapError, Exception):
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, Chunk):
                with suppress(Exception):  # a chunk that does not unpack is missing
                    yield from breakup_chunk(record)
            else:
                yield record


def _row(topic: str, record: Message) -> Row:
    return Row(topic, record.sequence, record.log_time, record.publish_time, record.data)


def decided(row: Row) -> bytes:
    """What is compared of a tick or a command: neither what nobody knows, nor what is given."""
    kind = Tick if row.topic.endswith("/tick") else Command
    try:
        message = kind.FromString(row.payload)
    except Exception:
        return row.payload
    told: Decision | Command = message.decision if isinstance(message, Tick) else message
    told.DiscardUnknownFields()  # type: ignore[attr-defined]  # its stub does not have it
    if isinstance(told, Decision):
        told.ClearField("slot")  # `LevelResult.given`
    return told.SerializeToString(deterministic=True)


def untruths(whole: Contents, found: Contents, report: ReplayReport) -> list[str]:
    """What a report says that is not so; empty if it tells the truth."""
    missing, changed = whole.rows - found.rows, found.rows - whole.rows
    is_changed = bool(changed or found.head - whole.head)
    wrong = []
    if report.exit_status == 1 and not is_changed:
        wrong.append("different, though nothing was changed")
    if report.verdict != "identical":
        return wrong
    if _decisions(whole.rows) - _decisions(found.rows) and not _says_less(report):
        wrong.append("identical, though a tick or command was changed or is missing")
    if _count(missing, "/tick") > _count(changed, "/tick") and not report.notes:
        wrong.append("identical, though ticks are missing and no note says so")
    return wrong


def _decisions(rows: Counter[Row]) -> Counter[bytes]:
    told: Counter[bytes] = Counter()
    for row, count in rows.items():
        if row.topic.endswith(("/tick", "/command")):
            told[row.topic.encode() + decided(row)] += count
    return told


def _count(rows: Counter[Row], ending: str) -> int:
    return sum(count for row, count in rows.items() if row.topic.endswith(ending))


def _says_less(report: ReplayReport) -> bool:
    """Whether it says of any tick or command that it is missing or was not compared."""
    words = ("not compared", "missing", "not in it", "left out", "no recorded command", "twice")
    return any(word in note for note in report.notes for word in words)


@dataclass
class FlipJudge:
    """Tries damaged forms of one log.

    Args:
        path: the whole log.
        scratch: a folder for the damaged ones.
    """

    path: Path
    scratch: Path

    def __post_init__(self) -> None:
        self.data = self.path.read_bytes()
        self.whole = contents(self.path)
        self.indexes = [*_index_bodies(self.data)]
        self.seen: Counter[str] = Counter()
        """Outcomes: of the damaged log, and of what was recovered of it."""

    def cut(self, dice: random.Random) -> list[str]:
        """Cut at a random byte; what was said that is not so."""
        size = dice.randrange(1, len(self.data))
        return [f"cut at {size}: {wrong}" for wrong in self.attempt(self.data[:size])]

    def flip(self, dice: random.Random) -> list[str]:
        """Flip a random bit; what was said that is not so."""
        place, bit = dice.randrange(len(self.data)), dice.randrange(8)
        changed = bytearray(self.data)
        changed[place] ^= 1 << bit
        return [f"bit {bit} of {place}: {wrong}" for wrong in self.attempt(bytes(changed))]

    def attempt(self, data: bytes) -> list[str]:
        """Replay these bytes, and what can be recovered of them."""
        damaged, saved = self.scratch / "damaged.mcap", self.scratch / "saved.mcap"
        legible = self.scratch / "legible.mcap"
        damaged.write_bytes(data)
        legible.write_bytes(self._legible(data))
        saved.unlink(missing_ok=True)
        wrong = [f"damaged: {one}" for one in self._replayed("damaged", damaged, legible)]
        try:
            recover(damaged, saved)
        except ReflexarcError:
            self.seen["recovered: nothing"] += 1
            return wrong
        return wrong + [f"recovered: {one}" for one in self._replayed("recovered", saved, saved)]

    def _legible(self, data: bytes) -> bytes:
        """The same with the message indexes as they were.

        They hold no message. The plain library reads nothing behind one that says that it, or its
        list, is longer than the file; the product does, and is right.
        """
        restored = bytearray(data)
        for place in self.indexes:
            restored[place] = self.data[place]
        return bytes(restored) if len(data) == len(self.data) else data

    def _replayed(self, name: str, path: Path, legible: Path) -> list[str]:
        try:
            report = replay(read_log(path, allow_truncated=True))
        except ReflexarcError:
            self.seen[f"{name}: refused"] += 1
            return []
        self.seen[f"{name}: {report.verdict}"] += 1
        return untruths(self.whole, contents(legible), report)


def _index_bodies(data: bytes) -> Iterator[slice]:
    """Where the message indexes of a whole log are, but for the byte that says what they are."""
    at = len(MAGIC)
    while at < len(data) - len(MAGIC):
        opcode, length = struct.unpack_from("<BQ", data, at)
        if opcode == MESSAGE_INDEX:
            yield slice(at + 1, at + 9 + length)
        at += 9 + length


def without_checks(path: Path, out: Path) -> Path:
    """The same log as a tool writes it that keeps no CRC and compresses nothing."""
    from mcap.writer import CompressionType, Writer

    with path.open("rb") as source, out.open("wb") as target:
        writer = Writer(
            target,
            chunk_size=1 << 13,
            compression=CompressionType.NONE,
            enable_crcs=False,
            enable_data_crcs=False,
        )
        writer.start(profile="", library="another tool")
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        for record in StreamReader(source).records:
            if isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
            elif isinstance(record, Attachment):
                writer.add_attachment(0, 0, record.name, record.media_type, record.data)
            elif isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic,
                    record.message_encoding,
                    schemas[record.schema_id],
                    record.metadata,
                )
            elif isinstance(record, Message):
                writer.add_message(
                    channels[record.channel_id],
                    record.log_time,
                    record.data,
                    record.publish_time,
                    record.sequence,
                )
        writer.finish()
    return out
