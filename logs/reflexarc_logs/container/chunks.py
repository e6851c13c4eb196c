"""Unpacks the chunks of an MCAP file within bounds of memory and time.

A chunk may unpack to 128 MiB; all chunks of a file together to 1 GiB and a hundred times its size.
They may hold half a million records, and one for every eight bytes of the file. That is the
difference between a log and a bomb: 4 KB of zstd are 128 MiB of zeros.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import lz4.frame  # type: ignore[import-untyped]  # it ships no types
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk, McapRecord

from reflexarc_logs.container.fields import decoded, message_at
from reflexarc_logs.container.frames import (
    HEAD,
    MAX_HELD_BYTES,
    DamagedError,
    NotReadHereError,
    check_held,
)

LEAST_ALLOWED_BYTES = 1 << 30
MOST_TIMES = 100
LEAST_ALLOWED_RECORDS = 500_000
BYTES_A_RECORD = 8
"""A message takes more of a file, however well it is compressed: its times are its own."""
COMPRESSIONS = ("", "zstd", "lz4")
"""All that the format names; an empty one: none."""

_COUNTED_TOGETHER = 1000
_UNPACKED = (Opcode.SCHEMA, Opcode.CHANNEL)


@dataclass
class Allowance:
    """What the chunks of one file may still unpack to."""

    left_bytes: int
    left_records: int

    @classmethod
    def of(cls, file_bytes: int) -> "Allowance":
        """The allowance of a file of this size."""
        return cls(
            LEAST_ALLOWED_BYTES + MOST_TIMES * file_bytes,
            LEAST_ALLOWED_RECORDS + file_bytes // BYTES_A_RECORD,
        )

    def take_bytes(self, count: int) -> None:
        """Use some of it.

        Raises:
            NotReadHereError: nothing is left.
        """
        self.left_bytes -= count
        if self.left_bytes < 0:
            raise NotReadHereError(f"chunks that unpack to over {MOST_TIMES} times the file's size")

    def take_records(self, count: int) -> None:
        """Use so many records of it.

        Raises:
            NotReadHereError: nothing is left.
        """
        self.left_records -= count
        if self.left_records < 0:
            raise NotReadHereError(
                f"chunks that unpack to a record for every {BYTES_A_RECORD} bytes of the file"
            )


def content_of(chunk: Chunk, allowance: Allowance) -> bytes:
    """What a chunk holds, unpacked, its CRC checked.

    Raises:
        DamagedError: it does not unpack, or its CRC does not fit.
        NotReadHereError: it is too large, or compressed in a way that is not read here.
    """
    if chunk.compression not in COMPRESSIONS:
        name = chunk.compression[:20]
        raise NotReadHereError(f"a chunk compressed with {name!r}, which is not read here")
    check_held(chunk.uncompressed_size, "a chunk")
    allowance.take_bytes(chunk.uncompressed_size)
    content = _unpacked(chunk)
    if chunk.uncompressed_crc and zlib.crc32(content) != chunk.uncompressed_crc:
        raise DamagedError("a chunk: its CRC does not fit")
    if len(content) != chunk.uncompressed_size:
        raise DamagedError("a chunk: it is not as long as it says")
    return content


def records_in(content: bytes, allowance: Allowance) -> Iterator[tuple[int, int, int]]:
    """Kind of each record of a chunk that was unpacked, where its fields begin, and where they end.

    Raises:
        DamagedError: it holds no whole number of records.
        NotReadHereError: more than the file's allowance.
    """
    at, end = 0, len(content)
    unpack_from, head, number = HEAD.unpack_from, HEAD.size, 0
    while at < end:
        number += 1
        if number == _COUNTED_TOGETHER:
            number -= _COUNTED_TOGETHER
            allowance.take_records(_COUNTED_TOGETHER)
        try:
            opcode, size = unpack_from(content, at)
        except struct.error:
            raise DamagedError("a chunk: it ends in the middle of a record") from None
        at += head
        if not opcode or size > end - at:
            raise DamagedError("a chunk: it ends in the middle of a record")
        yield opcode, at, at + size
        at += size
    allowance.take_records(number)


def heads_in(content: bytes, allowance: Allowance) -> Iterator[list[int]]:
    """Where the records of a chunk that was unpacked begin, a thousand at a time.

    The same walk as `records_in`, for who looks at all of them at once: a record of kind 0 is for
    the caller to refuse.

    Raises:
        DamagedError: it holds no whole number of records; behind the last whole one.
        NotReadHereError: more than the file's allowance.
    """
    at, end, unpack_from, head = 0, len(content), HEAD.unpack_from, HEAD.size
    while at < end:
        starts: list[int] = []
        begins = starts.append
        try:
            for _ in range(_COUNTED_TOGETHER):
                begins(at)
                at += unpack_from(content, at)[1] + head
                if at >= end:
                    break
        except struct.error:
            at = end + 1
        allowance.take_records(len(starts))
        if at > end:
            yield starts[:-1]
            raise DamagedError("a chunk: it ends in the middle of a record")
        yield starts


def unpack(chunk: Chunk, allowance: Allowance | None = None) -> Iterator[McapRecord]:
    """The schemas, channels and messages in a chunk, one after the other.

    Raises:
        DamagedError, NotReadHereError: see `content_of` and `records_in`.
    """
    allowed = Allowance.of(0) if allowance is None else allowance
    yield from records_of(content_of(chunk, allowed), allowed)


def records_of(content: bytes, allowance: Allowance) -> Iterator[McapRecord]:
    """The schemas, channels and messages in what a chunk held.

    Raises:
        DamagedError, NotReadHereError: see `records_in`.
    """
    for opcode, start, end in records_in(content, allowance):
        if opcode == Opcode.MESSAGE:
            yield message_at(content, start, end)
        elif opcode in _UNPACKED:
            record = decoded(opcode, content[start:end])
            if record is not None:
                yield record


def _unpacked(chunk: Chunk) -> bytes:
    """The bytes in a chunk: of those that it says and one more at most."""
    match chunk.compression:
        case "zstd":
            return _from_zstd(chunk.data, chunk.uncompressed_size)
        case "lz4":
            return _from_lz4(chunk.data, chunk.uncompressed_size)
    return chunk.data


def _from_zstd(data: bytes, size: int) -> bytes:
    decompressor = zstandard.ZstdDecompressor(max_window_size=MAX_HELD_BYTES)
    try:
        claimed = zstandard.frame_content_size(data)
        if claimed not in (-1, size):  # −1: the frame does not say
            raise DamagedError("a chunk: its zstd frame is not as long as its header says")
        if claimed == size:
            return decompressor.decompress(data)
        with decompressor.stream_reader(data) as stream:
            return stream.read(size + 1)
    except zstandard.ZstdError as error:
        raise DamagedError(f"a chunk: {error}") from None


def _from_lz4(data: bytes, size: int) -> bytes:
    try:
        unpacked: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    except (RuntimeError, EOFError) as error:
        raise DamagedError(f"a chunk: {error}") from None
    return unpacked
