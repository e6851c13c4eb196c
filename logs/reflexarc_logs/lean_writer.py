"""Writes an MCAP file as mcap's own `Writer` does, at a fraction of the time a message.

That writer makes an object and nine small writes of every message, three times in a scan that has a
pose: that takes longer than reading the scan. Here a message is one packed head before its payload,
and what a chunk says of itself is gathered when it closes. All other records are the library's own.
A chunk is compressed beside the caller, who fills the next one meanwhile: zstd needs no Python.

Source: the MCAP format specification, https://mcap.dev/spec.
"""

import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from typing import BinaryIO

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import LIBRARY_IDENTIFIER, MCAP0_MAGIC

DEFAULT_CHUNK_BYTES = 1024 * 1024
"""As in the library."""

_MESSAGE = int(Opcode.MESSAGE)
_MESSAGE_HEAD = struct.Struct("<BQHIQQ")
"""Opcode, length of what follows, channel, sequence, log time, publish time."""
_COUNTED_HEAD_BYTES = _MESSAGE_HEAD.size - struct.calcsize("<BQ")
_FOOTER_BEFORE_ITS_CRC = struct.Struct("<BQQQ")
"""Opcode, length of what follows, starts of the summary and of its offsets."""


class LeanWriter:
    """Writes one file. Its methods are those of `mcap.writer.Writer`.

    Args:
        stream: a file at its beginning.
        beside: what compresses.
        chunk_size: the bytes after which a chunk is closed.
    """

    def __init__(
        self, stream: BinaryIO, beside: Executor, chunk_size: int = DEFAULT_CHUNK_BYTES
    ) -> None:
        self._stream = stream
        self._beside = beside
        self._closed: tuple[_OpenChunk, Future[Chunk]] | None = None
        self._position = 0
        self._crc = 0
        self._chunk = _OpenChunk()
        self._chunk_size = chunk_size
        self._messages: Counter[int] = Counter()
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []

    def start(self, profile: str) -> None:
        """Write the header."""
        self._write(MCAP0_MAGIC)
        self._write(_packed(Header(profile, LIBRARY_IDENTIFIER)))

    def add_attachment(
        self, create_time: int, log_time: int, name: str, media_type: str, data: bytes
    ) -> None:
        """Write an attachment."""
        record = _packed(Attachment(create_time, log_time, name, media_type, data))
        index = AttachmentIndex(
            self._position, len(record), log_time, create_time, len(data), name, media_type
        )
        self._attachments.append(index)
        self._write(record)

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Write a metadata record."""
        record = _packed(Metadata(name, dict(data)))
        self._metadata.append(MetadataIndex(self._position, len(record), name))
        self._write(record)

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema; return its number."""
        schema = Schema(len(self._schemas) + 1, data, encoding, name)
        self._schemas.append(schema)
        self._chunk.add(_packed(schema))
        return schema.id

    def register_channel(self, topic: str, message_encoding: str, schema_id: int) -> int:
        """Add a channel; return its number."""
        channel = Channel(len(self._channels) + 1, topic, message_encoding, {}, schema_id)
        self._channels.append(channel)
        self._chunk.add(_packed(channel))
        return channel.id

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int
    ) -> None:
        """Add a message; times in nanoseconds, not negative."""
        length = _COUNTED_HEAD_BYTES + len(data)
        head = _MESSAGE_HEAD.pack(_MESSAGE, length, channel_id, sequence, log_time, publish_time)
        chunk = self._chunk
        chunk.messages[channel_id] += (log_time, chunk.size)
        chunk.parts += (head, data)
        chunk.size += _MESSAGE_HEAD.size + len(data)
        if chunk.size > self._chunk_size:
            self._close_chunk()

    def flush(self) -> None:
        """Write the messages that are not written yet."""
        self._close_chunk()
        self._write_chunk()
        self._stream.flush()

    def _close_chunk(self) -> None:
        self._write_chunk()
        if self._chunk.messages:
            self._closed = self._chunk, self._beside.submit(self._chunk.record)
            self._chunk = _OpenChunk()

    def _write_chunk(self) -> None:
        """Write the chunk that is being compressed, if there is one."""
        if self._closed is None:
            return
        (chunk, compressed), self._closed = self._closed, None
        record, begins_at = compressed.result(), self._position
        self._write(_packed(record))
        indexes_at, index_offsets = self._position, {}
        for channel, entries in chunk.messages.items():
            index_offsets[channel] = self._position
            self._messages[channel] += len(entries) // 2
            self._write(_message_index(channel, entries))
        self._chunks.append(
            ChunkIndex(
                chunk_start_offset=begins_at,
                chunk_length=indexes_at - begins_at,
                message_index_offsets=index_offsets,
                message_index_length=self._position - indexes_at,
                message_start_time=record.message_start_time,
                message_end_time=record.message_end_time,
                compression=record.compression,
                compressed_size=len(record.data),
                uncompressed_size=record.uncompressed_size,
            )
        )

    def finish(self) -> None:
        """Write what is left, and the summary."""
        self.flush()
        self._write(_packed(DataEnd(self._crc)))
        begins_at = self._position
        groups = [_packed(*records) for records in self._summary()]
        offsets = self._summary_offsets(groups)
        summary = b"".join([*groups, offsets])
        offsets_at = begins_at + len(summary) - len(offsets)
        footer_head = _FOOTER_BEFORE_ITS_CRC.pack(Opcode.FOOTER, 20, begins_at, offsets_at)
        footer = Footer(begins_at, offsets_at, zlib.crc32(footer_head, zlib.crc32(summary)))
        self._write(summary + _packed(footer) + MCAP0_MAGIC)

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._position += len(data)
        self._crc = zlib.crc32(data, self._crc)

    def _summary(self) -> Sequence[Sequence[McapRecord]]:
        """The groups of the summary."""
        return (
            self._schemas,
            self._channels,
            [self._statistics()],
            self._chunks,
            self._attachments,
            self._metadata,
        )

    def _summary_offsets(self, groups: Sequence[bytes]) -> bytes:
        """Where each group that has a record begins."""
        begins_at, offsets = self._position, []
        for group in groups:
            if group:
                opcode = group[0]  # of all its records
                offsets.append(SummaryOffset(opcode, begins_at, len(group)))
            begins_at += len(group)
        return _packed(*offsets)

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._messages,
            chunk_count=len(self._chunks),
            message_count=self._messages.total(),
            message_start_time=min((c.message_start_time for c in self._chunks), default=0),
            message_end_time=max((c.message_end_time for c in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )


class _OpenChunk:
    """Records that are not written yet."""

    def __init__(self) -> None:
        self.size = 0
        self.messages: defaultdict[int, list[int]] = defaultdict(list)
        """Log time and position of every message, one after the other, by channel."""
        self.parts: list[bytes] = []

    def add(self, record: bytes) -> None:
        """Add what is no message."""
        self.parts.append(record)
        self.size += len(record)

    def record(self) -> Chunk:
        """The record that holds them all."""
        data = b"".join(self.parts)
        times = [time for entries in self.messages.values() for time in entries[::2]]
        return Chunk(
            compression="zstd",
            data=zstandard.compress(data),
            message_start_time=min(times),
            message_end_time=max(times),
            uncompressed_crc=zlib.crc32(data),
            uncompressed_size=len(data),
        )


def _message_index(channel: int, entries: list[int]) -> bytes:
    """The record of all messages of a channel, which the library writes number by number."""
    size = 8 * len(entries)
    layout = f"<BQHI{len(entries)}Q"
    return struct.pack(layout, Opcode.MESSAGE_INDEX, 6 + size, channel, size, *entries)


def _packed(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]  # mcap has no type for it
    return data
