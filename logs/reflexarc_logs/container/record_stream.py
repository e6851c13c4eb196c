"""Reads an MCAP file as a stream of records, even if the file is truncated, damaged or forged.

Sizes are checked before memory is allocated: no record may reach beyond the end of the file, and no
chunk may unpack to more than 32 MiB. A chunk is used only if its CRC fits.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, BinaryIO, cast

import zstandard
from mcap.exceptions import EndOfFile, InvalidMagic, McapError
from mcap.records import Chunk, Footer, McapRecord
from mcap.stream_reader import StreamReader, breakup_chunk, get_chunk_data_stream

MAX_RECORD_BYTES = 320 << 20
"""The largest record is the attachment of a policy (at most 256 MiB)."""
MAX_CHUNK_BYTES = 32 << 20
"""What a chunk may unpack to; the recorder's hold 64 KiB and one message."""

_MAGIC_BYTES = 8
_CRC_BYTES = 4
_BLOCK_BYTES = 1 << 20
_DAMAGE = (
    McapError,
    ValueError,
    struct.error,
    zstandard.ZstdError,
    OverflowError,
    MemoryError,
)
"""What the MCAP library raises on bytes that are not what they should be."""


class NotMcapError(Exception):
    """The file does not begin as an MCAP file does."""


class TruncatedError(Exception):
    """The file ends in the middle."""


class DamagedError(Exception):
    """Bytes that are not what they should be: a CRC or a length does not fit."""


@dataclass(frozen=True, slots=True)
class Located:
    """A record and where it ends in the file."""

    record: McapRecord
    end: int


def stream_records(path: Path, limit: int | None = None) -> Iterator[Located]:
    """Yield the records of a file in its order; chunks are not unpacked.

    Args:
        path: the file.
        limit: where to stop reading, bytes; the end of the file if None.

    Raises:
        NotMcapError, TruncatedError, DamagedError: after the last record that is intact.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        size = path.stat().st_size if limit is None else limit
        bounded = _Bounded(file, size)
        records = StreamReader(
            cast("IO[bytes]", bounded),
            emit_chunks=True,
            validate_crcs=limit is None,
            record_size_limit=MAX_RECORD_BYTES,
        ).records
        while (record := _next(records, bounded)) is not None:
            if isinstance(record, Footer) and limit is None:
                _check_summary(file, record, bounded.position)
            yield Located(record, bounded.position)
        if bounded.position < size:
            raise DamagedError("there are bytes after its end")


def unpack(chunk: Chunk) -> list[McapRecord]:
    """The records in a chunk.

    Raises:
        DamagedError: it does not unpack, is too large, or its CRC does not fit.
    """
    _check_chunk(chunk)
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except _DAMAGE as error:
        raise DamagedError(f"a chunk: {_reason(error)}") from None


def chunk_content(chunk: Chunk) -> bytes:
    """A chunk, unpacked.

    Raises:
        DamagedError: it does not unpack, is too large, or its CRC does not fit.
    """
    _check_chunk(chunk)
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        return stream.read(length)
    except _DAMAGE as error:
        raise DamagedError(f"a chunk: {_reason(error)}") from None


class _Bounded:
    """A file that refuses to read beyond its end, so that a forged length allocates nothing."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file = file
        self._size = size
        self.position = 0

    def read(self, length: int) -> bytes:
        if length < 0:
            raise DamagedError("a record shorter than its own fields")
        if length > self._size - self.position:
            raise EndOfFile
        self.position += length
        return self._file.read(length)


def _next(records: Iterator[McapRecord], bounded: _Bounded) -> McapRecord | None:
    try:
        return next(records, None)
    except EndOfFile:
        raise (TruncatedError if bounded.position else NotMcapError) from None
    except InvalidMagic:
        if bounded.position > _MAGIC_BYTES:
            raise DamagedError("it does not end as an MCAP file does") from None
        raise NotMcapError from None
    except _DAMAGE as error:
        raise DamagedError(_reason(error)) from None


def _check_chunk(chunk: Chunk) -> None:
    """Check the sizes that the chunk's header and its compressed frame claim."""
    if chunk.compression not in ("zstd", ""):
        raise DamagedError(f"a chunk: expected zstd, got compression {chunk.compression[:20]!r}")
    sizes = [chunk.uncompressed_size]
    if chunk.compression:
        try:
            sizes.append(zstandard.frame_content_size(chunk.data))
        except zstandard.ZstdError as error:
            raise DamagedError(f"a chunk: {error}") from None
    if max(sizes) > MAX_CHUNK_BYTES:
        raise DamagedError(f"a chunk: expected at most 32 MiB, got {max(sizes)} bytes")


def _check_summary(file: BinaryIO, footer: Footer, end: int) -> None:
    """Check the CRC of the index that ends at `end`; replay does not use it, but viewers do."""
    if not footer.summary_crc:
        return
    file.seek(footer.summary_start)
    left = end - _CRC_BYTES - footer.summary_start
    crc = 0
    while left > 0 and (block := file.read(min(left, _BLOCK_BYTES))):
        crc = zlib.crc32(block, crc)
        left -= len(block)
    file.seek(end)
    if crc != footer.summary_crc:
        raise DamagedError("the CRC of its index does not fit")


def _reason(error: BaseException) -> str:
    return " ".join(str(error).split())[:160] or type(error).__name__
