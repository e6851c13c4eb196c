"""The frame of an MCAP file: where each record begins, of what kind it is, and where it ends.

A record is one byte of kind, eight of length, and its fields. Lengths are checked before anything
is read: no record reaches beyond the end of the file, and nothing large is held in memory.
"""

import os
import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""Before the fields of each record: its kind and their length."""
DATA_END_BYTES = 4
FOOTER_BYTES = 20
CRC_BYTES = 4
MAX_HELD_BYTES = 128 << 20
"""The largest record, attachments aside, that is read into memory, and what a chunk may unpack to.

The recorder's chunks hold 64 KiB and one message; those of other tools usually 1 to 8 MiB."""

_BLOCK_BYTES = 1 << 20


class NotMcapError(Exception):
    """The file does not begin as an MCAP file does."""


class TruncatedError(Exception):
    """The file ends in the middle."""


class DamagedError(Exception):
    """Bytes that are not what they should be: a CRC or a length does not fit."""


class NotReadHereError(Exception):
    """What the format allows and this reader does not take; it is no damage."""


class Frame(NamedTuple):
    """A record in a file, not read yet."""

    opcode: int
    start: int
    """Offset of its first byte."""
    size: int
    """Bytes of its fields."""

    @property
    def body(self) -> int:
        """Offset of its fields."""
        return self.start + HEAD.size

    @property
    def end(self) -> int:
        """Offset behind its last byte."""
        return self.start + HEAD.size + self.size


class FrameReader:
    """Reads a file from a place on, forward, and keeps the CRC of all that it has read.

    Args:
        file: an open file; nobody else may move its position meanwhile.
        end: where to stop.
        start: where to begin.

    Raises:
        TruncatedError: the file ends before it begins.
    """

    def __init__(self, file: BinaryIO, end: int, start: int = 0) -> None:
        self._file = file
        self._end = min(end, os.fstat(file.fileno()).st_size)
        if start > self._end:
            raise TruncatedError
        self.position = start
        self.crc = 0
        file.seek(start)

    @property
    def left(self) -> int:
        """Bytes up to the end."""
        return self._end - self.position

    def read(self, count: int) -> bytes:
        """The next bytes.

        Raises:
            TruncatedError: there are fewer.
        """
        if count > self.left:
            raise TruncatedError
        data = self._file.read(count)
        if len(data) < count:
            raise TruncatedError  # it became shorter meanwhile
        self.position += count
        self.crc = zlib.crc32(data, self.crc)
        return data

    def magic(self) -> None:
        """Read the eight bytes that an MCAP file begins with.

        Raises:
            NotMcapError: they are others.
        """
        if self.left < len(MAGIC) or self.read(len(MAGIC)) != MAGIC:
            raise NotMcapError

    def frame(self) -> Frame:
        """The kind and the length of the next record.

        Raises:
            TruncatedError: the file ends before it does.
            DamagedError: no record can begin so.
        """
        start = self.position
        opcode, size = HEAD.unpack(self.read(HEAD.size))
        if not opcode:
            raise DamagedError("a record of no kind")
        if size > self.left:
            raise TruncatedError
        return Frame(opcode, start, size)

    def fields(self, frame: Frame) -> bytes:
        """The fields of the record whose head was just read.

        Raises:
            NotReadHereError: they are too large to be held.
        """
        check_held(frame.size)
        return self.read(frame.size)

    def read_through(self, frame: Frame) -> None:
        """Pass over the fields of that record, for their CRC."""
        while (left := frame.end - self.position) > 0:
            self.read(min(left, _BLOCK_BYTES))

    def seek_behind(self, frame: Frame) -> None:
        """Pass over the fields of that record without reading them."""
        self._file.seek(frame.end - self.position, os.SEEK_CUR)
        self.position = frame.end


def check_held(size: int, what: str = "a record") -> None:
    """Refuse what is too large to be held in memory.

    Raises:
        NotReadHereError: with the limit.
    """
    if size > MAX_HELD_BYTES:
        limit = MAX_HELD_BYTES >> 20
        raise NotReadHereError(f"{what} of {size} bytes, more than the {limit} MiB that are read")


def blocks(file: BinaryIO, start: int, end: int) -> Iterator[bytes]:
    """The bytes of a part of a file, at most 1 MiB at a time.

    Raises:
        TruncatedError: the file ends before.
    """
    file.seek(start)
    while start < end:
        block = file.read(min(end - start, _BLOCK_BYTES))
        if not block:
            raise TruncatedError
        start += len(block)
        yield block


def crc_of(file: BinaryIO, start: int, end: int) -> int:
    """The CRC of a part of a file."""
    crc = 0
    for block in blocks(file, start, end):
        crc = zlib.crc32(block, crc)
    return crc


def check_footer(file: BinaryIO, frame: Frame) -> None:
    """Check the CRC in a footer: of the index before it, or, without one, of its own two offsets.

    Raises:
        DamagedError: it does not fit.
    """
    file.seek(frame.body)
    summary_start, _, crc = struct.unpack("<QQI", file.read(FOOTER_BYTES))
    start = summary_start or frame.start
    if start > frame.start:
        raise DamagedError("its index begins behind its end")
    if crc and crc != crc_of(file, start, frame.end - CRC_BYTES):
        raise DamagedError("the CRC of its index does not fit")


def is_exact(frame: Frame) -> bool:
    """Whether a record that has a fixed length has it."""
    fixed = {Opcode.DATA_END: DATA_END_BYTES, Opcode.FOOTER: FOOTER_BYTES}
    return frame.size == fixed.get(Opcode(frame.opcode), frame.size)
