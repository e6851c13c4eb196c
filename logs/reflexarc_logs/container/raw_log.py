"""Writes an MCAP file of records that are ready, byte for byte, and makes its index.

The library's writer makes records of its own; this one takes them as they are: chunks as they were
compressed, fields that it does not know, messages outside of chunks.
"""

import struct
import zlib
from array import array
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    ChunkIndex,
    DataEnd,
    McapRecord,
    Metadata,
    MetadataIndex,
    Statistics,
    SummaryOffset,
)

from reflexarc_logs.container.attachments import Attached
from reflexarc_logs.container.frames import FOOTER_BYTES, HEAD, MAGIC
from reflexarc_logs.container.packing.kept_index import KeptIndex
from reflexarc_logs.container.unfinished import PARTIAL, UnfinishedFile


@dataclass
class ChunkContent:
    """What a chunk holds, as its index needs it."""

    compression: str
    compressed_size: int
    uncompressed_size: int
    entries: "dict[int, array[int]]" = field(default_factory=dict)
    """By channel, one after the other: log time and place of each message."""

    def add(self, channel: int, log_ns: int, place: int) -> None:
        """Take a message in."""
        self.entries.setdefault(channel, array("Q")).extend((log_ns, place))

    @property
    def counts(self) -> dict[int, int]:
        """Messages of each channel."""
        return {channel: len(entries) // 2 for channel, entries in self.entries.items()}

    @property
    def first_ns(self) -> int:
        """Earliest log time; 0 without messages."""
        return min((min(entries[::2]) for entries in self.entries.values()), default=0)

    @property
    def last_ns(self) -> int:
        """Latest log time; 0 without messages."""
        return max((max(entries[::2]) for entries in self.entries.values()), default=0)


class RawLog:
    """A file of ready records that one thread writes.

    Args:
        path: its name when it is finished.
        unfinished: what is added to the name until then.

    Raises:
        LogError: something of that name is there already, or the place cannot be written.
    """

    def __init__(self, path: Path, unfinished: str = PARTIAL) -> None:
        self.file = UnfinishedFile(path, unfinished)
        self.counts: Counter[int] = Counter()
        """Messages written, by channel."""
        self._position = 0
        self._crc = 0
        self._known: dict[int, dict[int, bytes]] = {Opcode.SCHEMA: {}, Opcode.CHANNEL: {}}
        self._chunks = KeptIndex()
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._times_ns: tuple[int, int] | None = None
        self._write(MAGIC)

    def record(self, opcode: int, fields: bytes) -> None:
        """Write a record of any kind."""
        self._write(HEAD.pack(opcode, len(fields)))
        self._write(fields)

    @property
    def totals(self) -> tuple[int, int, int]:
        """Messages, attachments and metadata records written."""
        return self.counts.total(), len(self._attachments), len(self._metadata)

    def define(self, opcode: int, number: int, fields: bytes, *, is_written: bool = True) -> None:
        """Write a schema or a channel; or only note that it stands in a chunk."""
        self._known[opcode].setdefault(number, fields)
        if is_written:
            self.record(opcode, fields)

    def knows(self, opcode: int, number: int) -> bool:
        """Whether that schema or channel is in the file by now."""
        return number in self._known[opcode]

    def message(self, channel: int, log_ns: int, fields: bytes) -> None:
        """Write a message that stands in no chunk."""
        self.record(Opcode.MESSAGE, fields)
        self._count({channel: 1}, log_ns, log_ns)

    def chunk(self, fields: bytes, content: ChunkContent) -> None:
        """Write a chunk as it is, and the index of its messages."""
        start = self._position
        self.record(Opcode.CHUNK, fields)
        length, offsets = self._position - start, {}
        for channel, entries in content.entries.items():
            offsets[channel] = self._position
            self.record(Opcode.MESSAGE_INDEX, index_fields(channel, entries))
        if content.entries:
            self._count(content.counts, content.first_ns, content.last_ns)
        self._chunks.add(
            bytes_of(
                ChunkIndex(
                    chunk_length=length,
                    chunk_start_offset=start,
                    compression=content.compression,
                    compressed_size=content.compressed_size,
                    message_end_time=content.last_ns,
                    message_index_length=self._position - start - length,
                    message_index_offsets=offsets,
                    message_start_time=content.first_ns,
                    uncompressed_size=content.uncompressed_size,
                )
            )
        )

    def attachment(self, attached: Attached, size: int, blocks: Iterable[bytes]) -> None:
        """Write an attachment of `size` bytes of fields, a block at a time."""
        start = self._position
        self._write(HEAD.pack(Opcode.ATTACHMENT, size))
        for block in blocks:
            self._write(block)
        self._attachments.append(
            AttachmentIndex(
                offset=start,
                length=self._position - start,
                log_time=attached.log_ns,
                create_time=attached.created_ns,
                data_size=attached.size,
                name=attached.name,
                media_type=attached.media_type,
            )
        )

    def metadata(self, name: str, fields: bytes) -> None:
        """Write a metadata record."""
        start = self._position
        self.record(Opcode.METADATA, fields)
        self._metadata.append(MetadataIndex(start, self._position - start, name))

    def describe(self, name: str, document: Mapping[str, str]) -> None:
        """Write a metadata record of our own."""
        self.metadata(name, bytes_of(Metadata(name, dict(document)))[HEAD.size :])

    def finish(self) -> None:
        """Write the index, make the file durable and give it its name."""
        self.seal()
        self.file.settle()

    def seal(self) -> None:
        """Write the index; nothing can be added any more."""
        self._write(bytes_of(DataEnd(self._crc)))
        self._crc, start = 0, self._position
        groups = [self._group(*group) for group in self._summary()]
        offsets_start = self._position
        for group in groups:
            if group.group_length:
                self._write(bytes_of(group))
        self._write(HEAD.pack(Opcode.FOOTER, FOOTER_BYTES))
        self._write(struct.pack("<QQ", start, offsets_start))
        self._write(struct.pack("<I", self._crc) + MAGIC)
        self.file.flush()

    def discard(self) -> None:
        """Close the file and remove it."""
        self.file.discard()

    def _summary(self) -> Iterator[tuple[int, Iterable[bytes]]]:
        """The groups of the index: their kind, and their records."""
        for opcode, known in self._known.items():
            yield opcode, (HEAD.pack(opcode, len(f)) + f for f in known.values())
        yield Opcode.STATISTICS, [bytes_of(self._statistics())]
        yield Opcode.CHUNK_INDEX, self._chunks.blocks()
        yield Opcode.ATTACHMENT_INDEX, map(bytes_of, self._attachments)
        yield Opcode.METADATA_INDEX, map(bytes_of, self._metadata)

    def _group(self, opcode: int, records: Iterable[bytes]) -> SummaryOffset:
        start = self._position
        for record in records:
            self._write(record)
        return SummaryOffset(opcode, start, self._position - start)

    def _statistics(self) -> Statistics:
        first_ns, last_ns = self._times_ns or (0, 0)
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._known[Opcode.CHANNEL]),
            channel_message_counts=dict(self.counts),
            chunk_count=self._chunks.count,
            message_count=self.counts.total(),
            message_end_time=last_ns,
            message_start_time=first_ns,
            metadata_count=len(self._metadata),
            schema_count=len(self._known[Opcode.SCHEMA]),
        )

    def _count(self, counts: Mapping[int, int], first_ns: int, last_ns: int) -> None:
        self.counts.update(counts)
        first, last = self._times_ns or (first_ns, last_ns)
        self._times_ns = min(first, first_ns), max(last, last_ns)

    def _write(self, data: bytes) -> None:
        self.file.write(data)
        self._position += len(data)
        self._crc = zlib.crc32(data, self._crc)


def index_fields(channel: int, entries: "array[int]") -> bytes:
    """The fields of the message index of a channel in a chunk."""
    return struct.pack(f"<HI{len(entries)}Q", channel, 8 * len(entries), *entries)


def bytes_of(record: McapRecord) -> bytes:
    """A record with its head."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap has no type for it
