"""The fields of an MCAP record: bytes become the record types of the MCAP library, and no less.

The library takes a text that is cut short for the whole of it; here every field must be there.
"""

import struct
from collections.abc import Callable, Mapping
from typing import IO, Any, Protocol, cast

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from reflexarc_logs.container.frames import DamagedError

MESSAGE = struct.Struct("<HIQQ")
"""Channel, sequence, log time and publish time of a message; its payload follows."""

_DAMAGE = (McapError, ValueError, struct.error, OverflowError)
"""What the MCAP library raises on bytes that are not what they should be."""

_READERS: Mapping[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.HEADER: Header.read,
    Opcode.FOOTER: Footer.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.MESSAGE_INDEX: MessageIndex.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex.read,
    Opcode.METADATA: Metadata.read,
    Opcode.METADATA_INDEX: MetadataIndex.read,
    Opcode.STATISTICS: Statistics.read,
    Opcode.SUMMARY_OFFSET: SummaryOffset.read,
    Opcode.DATA_END: DataEnd.read,
}


class FieldSource(Protocol):
    """Where fields are read from."""

    def read(self, count: int, /) -> Any:
        """So many bytes."""


class _Exact:
    """A source that has what it is asked for, or raises."""

    def __init__(self, source: FieldSource) -> None:
        self._source = source

    def read(self, count: int) -> bytes:
        if count < 0:
            raise DamagedError("a record shorter than its own fields")
        data = bytes(self._source.read(count))
        if len(data) < count:
            raise EndOfFile
        return data


class _Bytes:
    """Bytes as a source that does not copy more than it is asked for."""

    def __init__(self, data: bytes) -> None:
        self._data = memoryview(data)
        self._at = 0

    def read(self, count: int) -> memoryview:
        taken = self._data[self._at : self._at + count]
        self._at += len(taken)
        return taken


def decoded(opcode: int, fields: bytes) -> McapRecord | None:
    """A record from its fields; None of an attachment, and of a kind that is not known.

    Raises:
        DamagedError: the fields cannot be those of such a record.
    """
    if opcode == Opcode.MESSAGE:
        return message_at(fields, 0, len(fields))
    return None if opcode not in _READERS else read_fields(opcode, _Bytes(fields))[0]


def read_fields(opcode: int, source: FieldSource) -> tuple[McapRecord, int]:
    """A record, and how many bytes its own fields take; a message's cannot be told.

    Raises:
        DamagedError: these are no such fields.
    """
    stream = ReadDataStream(cast("IO[bytes]", _Exact(source)))
    try:
        return _READERS[opcode](stream), stream.count
    except EndOfFile:
        raise DamagedError("a record shorter than its own fields") from None
    except _DAMAGE as error:
        raise DamagedError(" ".join(str(error).split())[:160] or type(error).__name__) from None


def is_measurable(opcode: int) -> bool:
    """Whether the fields of such a record say how long they are."""
    return opcode in _READERS


def message_at(data: bytes, start: int, end: int) -> Message:
    """A message whose fields stand at a place in these bytes; its payload alone is copied.

    Raises:
        DamagedError: they are too few.
    """
    if end - start < MESSAGE.size:
        raise DamagedError("a record shorter than its own fields")
    channel, sequence, log_ns, publish_ns = MESSAGE.unpack_from(data, start)
    return Message(channel, log_ns, data[start + MESSAGE.size : end], publish_ns, sequence)
