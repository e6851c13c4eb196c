"""The index at the end of an MCAP file: what it holds, without reading it."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    ChunkIndex,
    McapRecord,
    MessageIndex,
    MetadataIndex,
    Schema,
    Statistics,
)

from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.frames import (
    CRC_BYTES,
    FOOTER_BYTES,
    HEAD,
    MAGIC,
    DamagedError,
    Frame,
    FrameReader,
    NotReadHereError,
    TruncatedError,
    crc_of,
)

MAX_INDEX_BYTES = 64 << 20
_INDEXED = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
    Opcode.STATISTICS,
)


@dataclass
class Index:
    """What the summary section of a file says."""

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[ChunkIndex] = field(default_factory=list)
    attachments: list[AttachmentIndex] = field(default_factory=list)
    metadata: list[MetadataIndex] = field(default_factory=list)
    statistics: Statistics | None = None
    is_shifted: bool = False
    """Whether it stands elsewhere than its offsets were made for."""
    raw: dict[tuple[int, int], bytes] = field(default_factory=dict)
    """The fields of schemas and channels as they stand there, by kind and number."""
    is_proven: bool = True
    """Whether it has a CRC; one that has none may be damaged itself."""
    start: int = 0
    """Where it stands in the file; the end of the data is right before it."""

    @property
    def totals(self) -> tuple[int, int, int] | None:
        """Messages, attachments and metadata records; None if it does not say."""
        said = self.statistics
        if said is None:
            return None
        return said.message_count, said.attachment_count, said.metadata_count

    @property
    def counts(self) -> dict[int, int] | None:
        """Messages of each channel; None if it does not say, or contradicts itself."""
        if self.statistics is None:
            return None
        counts = self.statistics.channel_message_counts
        return counts if sum(counts.values()) == self.statistics.message_count else None


def likely_index(path: Path) -> Index | None:
    """The index of a file; of one that has no CRC as well, if its records are whole."""
    try:
        with path.open("rb") as file:
            return likely_index_in(file, path.stat().st_size)
    except OSError:
        return None


def likely_index_in(file: BinaryIO, size: int) -> Index | None:
    """The index of an open file of this size; see `likely_index`."""
    return index_in(file, size) or index_in(file, size, is_proven=False)


def read_index(path: Path, data_end: int | None = None) -> Index | None:
    """The index of a file; None if it has none that is intact and has a CRC.

    Args:
        path: the file.
        data_end: where its data was seen to end, if bytes before that may be missing: its index
            says where it was to begin, and may stand elsewhere by now.
    """
    try:
        with path.open("rb") as file:
            return index_in(file, path.stat().st_size, data_end)
    except OSError:
        return None


def index_in(
    file: BinaryIO, size: int, data_end: int | None = None, *, is_proven: bool = True
) -> Index | None:
    """The index of an open file of this size; see `read_index`.

    `is_proven`: whether it must have a CRC; else it must have none.
    """
    try:
        start, end = _place(file, size, data_end, is_proven)
        index = Index(is_shifted=data_end is not None, start=start, is_proven=is_proven)
        for record, fields in _records(file, start, end):
            _note(index, record, fields)
    except (DamagedError, TruncatedError, NotReadHereError, struct.error):
        return None
    return index


def message_index_at(file: BinaryIO, offset: int, size: int) -> MessageIndex:
    """The message index that stands at this place of a file of this size.

    Raises:
        DamagedError, TruncatedError: there is none.
    """
    reader = FrameReader(file, size, offset)
    frame = reader.frame()
    if frame.opcode != Opcode.MESSAGE_INDEX or frame.size > MAX_INDEX_BYTES:
        raise DamagedError("a message index: something else is there")
    record = decoded(frame.opcode, reader.fields(frame))
    if not isinstance(record, MessageIndex):
        raise DamagedError("a message index: something else is there")
    return record


def _place(file: BinaryIO, size: int, data_end: int | None, is_proven: bool) -> tuple[int, int]:
    """Where the index begins and ends, if it is whole and stands behind the end of the data."""
    footer = Frame(Opcode.FOOTER, size - len(MAGIC) - HEAD.size - FOOTER_BYTES, FOOTER_BYTES)
    if footer.start < len(MAGIC):
        raise TruncatedError
    file.seek(footer.start)
    tail = file.read()
    if tail[: HEAD.size] != HEAD.pack(Opcode.FOOTER, FOOTER_BYTES) or not tail.endswith(MAGIC):
        raise TruncatedError
    start, _, crc = struct.unpack_from("<QQI", tail, HEAD.size)
    has_index = start and bool(crc) == is_proven
    start = start if data_end is None else data_end
    if not has_index or not 0 < footer.start - start <= MAX_INDEX_BYTES:
        raise DamagedError("no index that can be relied on")
    if crc and crc != crc_of(file, start, footer.end - CRC_BYTES):
        raise DamagedError("the CRC of its index does not fit")
    return start, footer.start


def _records(file: BinaryIO, start: int, end: int) -> Iterator[tuple[McapRecord, bytes]]:
    reader = FrameReader(file, end, start)
    while reader.left:
        frame = reader.frame()
        if frame.opcode not in _INDEXED:
            reader.seek_behind(frame)
            continue
        fields = reader.fields(frame)
        record = decoded(frame.opcode, fields)
        if record is not None:
            yield record, fields


def _note(index: Index, record: McapRecord, fields: bytes) -> None:
    match record:
        case Schema():
            index.schemas[record.id] = record
            index.raw[Opcode.SCHEMA, record.id] = fields
        case Channel():
            index.channels[record.id] = record
            index.raw[Opcode.CHANNEL, record.id] = fields
        case ChunkIndex():
            index.chunks.append(record)
        case AttachmentIndex():
            index.attachments.append(record)
        case MetadataIndex():
            index.metadata.append(record)
        case Statistics():
            index.statistics = record
