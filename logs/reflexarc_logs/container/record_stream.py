"""Reads the data of an MCAP file as a stream of records, up to where it is intact.

Attachments and indexes are passed over; chunks are yielded as they are, see `chunks.unpack`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Chunk, McapRecord

from reflexarc_logs.container.chunks import Allowance, content_of, records_of
from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.frames import FrameReader, TruncatedError

_DATA = (
    Opcode.HEADER,
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.MESSAGE,
    Opcode.CHUNK,
    Opcode.METADATA,
    Opcode.DATA_END,
)


@dataclass(frozen=True, slots=True)
class Located:
    """A record and where it ends in the file."""

    record: McapRecord
    end: int


def stream_records(path: Path, limit: int | None = None) -> Iterator[Located]:
    """Yield the records of a file's data, in its order.

    Args:
        path: the file.
        limit: where to stop reading, bytes; the end of the file if None.

    Raises:
        NotMcapError, TruncatedError, DamagedError: after the last record that is intact.
        NotReadHereError: a record is too large to be held.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        reader = FrameReader(file, path.stat().st_size if limit is None else limit)
        reader.magic()
        while reader.left:
            frame = reader.frame()
            if frame.opcode not in _DATA:
                reader.seek_behind(frame)
                continue
            record = decoded(frame.opcode, reader.fields(frame))
            if record is not None:
                yield Located(record, frame.end)
            if frame.opcode == Opcode.DATA_END:
                return


@dataclass(frozen=True, slots=True)
class ChunkBytes:
    """What a chunk holds, unpacked, and how many records the file may still have."""

    content: bytes
    allowance: Allowance


def whole_records(path: Path, end: int, size: int) -> Iterator[McapRecord]:
    """The records of any MCAP file up to a place, chunks unpacked; size: of the whole file.

    Raises:
        DamagedError: bytes that are not what they should be.
        NotReadHereError: what the format allows and is not read.
        OSError: it cannot be read.
    """
    for part in whole_parts(path, end, size):
        if isinstance(part, ChunkBytes):
            yield from records_of(part.content, part.allowance)
        else:
            yield part


def whole_parts(path: Path, end: int, size: int) -> Iterator[McapRecord | ChunkBytes]:
    """The same, each chunk as one piece of bytes, for who needs no object for each record.

    Raises:
        DamagedError, NotReadHereError, OSError: see `whole_records`.
    """
    allowance = Allowance.of(size)
    try:
        for located in stream_records(path, end):
            if isinstance(located.record, Chunk):
                yield ChunkBytes(content_of(located.record, allowance), allowance)
            else:
                yield located.record
    except TruncatedError:
        return  # the end of the intact part
