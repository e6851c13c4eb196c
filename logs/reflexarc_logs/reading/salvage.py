"""Finds the records of a damaged MCAP file, also behind the place where their chain breaks.

Where a record's kind or length was changed, its own fields still tell where it ends. Where they do
not, the next thing that proves itself is searched for: a chunk or an attachment whose CRC fits, or
a chain of records. What is skipped on the way is a hole.
"""

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from mcap.opcode import Opcode
from mcap.records import Chunk

from reflexarc_logs.container.attachments import attached_at, is_intact
from reflexarc_logs.container.chunks import Allowance, content_of, records_in
from reflexarc_logs.container.fields import decoded, is_measurable, read_fields
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    DATA_END_BYTES,
    FOOTER_BYTES,
    HEAD,
    MAGIC,
    DamagedError,
    Frame,
    NotReadHereError,
    TruncatedError,
)

_HEAD_LIKE = re.compile(rb"(?=[\x01-\x0f].{4}\x00{4})", re.DOTALL)
"""A kind that the format has, and a length below 4 GiB."""
_FIXED = {Opcode.DATA_END: DATA_END_BYTES, Opcode.FOOTER: FOOTER_BYTES}
_INDEX_HEAD = struct.Struct("<HI")
"""Channel of a message index, and the length of its entries."""
_INDEX_ENTRY_BYTES = 16
_PRIVATE = 0x80
_CHAIN = 3
"""So many records in a row are no accident."""
_SEARCHED_TIMES = 4
_LEAST_SEARCHED_BYTES = 64 << 20
_LOOK_BYTES = 4096
"""What a look at one place is counted as: a file in which every byte looks like a beginning ends
the search, and what its index knows is taken."""


@dataclass(frozen=True, slots=True)
class Hole:
    """A part of the file that is no record."""

    start: int
    end: int


Found: TypeAlias = Frame | Hole


@dataclass
class Salvage:
    """One walk over a file; what it yields ends with the data, or with the file.

    Args:
        data: the file.
        is_whole: whether its lengths can be trusted, because the CRC of its data fits.
        chunks: where its index says that chunks begin; None: it has no index.
    """

    data: FileBytes
    is_whole: bool
    chunks: frozenset[int] | None
    end: int = 0
    """Where the walk is; at last, where the data ended."""
    has_ended: bool = False
    """Whether the end of the data was found."""
    _unchunked: bool = False
    _effort_bytes: int = field(init=False)

    def __post_init__(self) -> None:
        self._effort_bytes = _SEARCHED_TIMES * self.data.size + _LEAST_SEARCHED_BYTES

    def walk(self) -> Iterator[Found]:
        """Records and holes in the order of the file."""
        self.end = self._beginning()
        if self.end > len(MAGIC):
            yield Hole(0, self.end)
        while self.end < self.data.size and not self.has_ended:
            frame = self._record(self.end)
            if frame is None:
                start, self.end = self.end, self._next_anchor(self.end + 1)
                yield Hole(start, self.end)
                continue
            self.has_ended = frame.opcode == Opcode.DATA_END
            self._unchunked |= frame.opcode == Opcode.MESSAGE
            self.end = frame.end
            yield frame

    def _beginning(self) -> int:
        """Where the first record is; a file may have lost its first bytes."""
        if self.data.at(0, len(MAGIC)) == MAGIC or self._is_link(len(MAGIC)):
            return len(MAGIC)
        return self._next_anchor(0)

    def _record(self, at: int) -> Frame | None:
        """The record at a place, with its true kind and length; None: there is none."""
        head = self._head(at)
        if head is None:
            return None
        if self.is_whole:
            return head if head.end <= self.data.size else None
        natural = self._natural_size(head.opcode, at)
        if natural is not None:
            as_told = Frame(head.opcode, at, natural)
            if as_told.end <= self.data.size and (
                natural == head.size or self._is_link(as_told.end)
            ):
                return as_told
        if (chunk := self._chunk(at)) is not None:
            return chunk
        is_padded = natural is not None and natural < head.size
        if (is_padded or not _is_measured(head.opcode)) and self._is_followed(head):
            return head
        return None

    def _head(self, at: int) -> Frame | None:
        head = self.data.at(at, HEAD.size)
        if len(head) < HEAD.size:
            return None
        opcode, size = HEAD.unpack(head)
        return Frame(opcode, at, size) if opcode else None

    def _natural_size(self, opcode: int, at: int) -> int | None:
        """How long a record of this kind is by its own fields; None if they make no sense."""
        if opcode in _FIXED:
            return _FIXED[Opcode(opcode)]
        if opcode == Opcode.MESSAGE_INDEX:
            return self._message_index_size(at)
        try:
            if opcode == Opcode.ATTACHMENT:
                frame = Frame(opcode, at, self.data.size - at - HEAD.size)
                return attached_at(self.data.file, frame).end - frame.body
            if is_measurable(opcode):
                return read_fields(opcode, self.data.source(at + HEAD.size))[1]
        except (DamagedError, MemoryError):
            pass
        return None

    def _message_index_size(self, at: int) -> int | None:
        """As `_natural_size`, without a look at each of its many entries."""
        head = self.data.at(at + HEAD.size, _INDEX_HEAD.size)
        if len(head) < _INDEX_HEAD.size:
            return None
        length = int(_INDEX_HEAD.unpack(head)[1])
        return None if length % _INDEX_ENTRY_BYTES else _INDEX_HEAD.size + length

    def _is_followed(self, frame: Frame) -> bool:
        """Whether something that looks like a record follows, or the file ends with it."""
        return frame.end == self.data.size or (
            frame.end < self.data.size and self._is_link(frame.end)
        )

    def _is_link(self, at: int) -> bool:
        """Whether what stands there looks like the head of a record that fits into the file."""
        if at == self.data.size:
            return True
        head = self._head(at)
        if head is None or head.size != _FIXED.get(head.opcode, head.size):  # type: ignore[call-overload]  # any number may be asked for
            return False
        return head.end <= self.data.size and (
            head.opcode <= max(Opcode) or head.opcode >= _PRIVATE
        )

    def _chunk(self, at: int) -> Frame | None:
        """The chunk whose fields stand behind this head, whatever the head says; its CRC fits."""
        size = self._natural_size(Opcode.CHUNK, at)
        if size is None or self._effort_bytes < 0:
            return None
        frame = Frame(Opcode.CHUNK, at, size)
        self._effort_bytes -= size
        return frame if self._proves_itself(frame) else None

    def _proves_itself(self, frame: Frame) -> bool:
        try:
            chunk = decoded(Opcode.CHUNK, self.data.at(frame.body, frame.size))
            if not isinstance(chunk, Chunk):
                return False
            self._effort_bytes -= chunk.uncompressed_size
            allowed = Allowance.of(self.data.size)
            content = content_of(chunk, allowed)
            if not chunk.uncompressed_crc:
                return bool(content) and all(True for _ in records_in(content, allowed))
        except (DamagedError, NotReadHereError):
            return False
        return True

    def _next_anchor(self, start: int) -> int:
        """The next place where a record proves itself; the end of the file if there is none."""
        for at in self.data.search(_HEAD_LIKE, start, HEAD.size):
            if self._effort_bytes < 0:
                break
            before = self.data.bytes_read
            if self._is_anchor(at):
                return at
            self._effort_bytes -= _LOOK_BYTES + self.data.bytes_read - before
        known = (at for at in self.chunks or () if at >= start)
        return min(known, default=self.data.size) if self._effort_bytes < 0 else self.data.size

    def _is_anchor(self, at: int) -> bool:
        head = self._head(at)
        if head is None or head.end > self.data.size:
            return False
        match head.opcode:
            case Opcode.CHUNK:
                is_known = self.chunks is None or at in self.chunks
                return is_known and self._chunk(at) is not None
            case Opcode.ATTACHMENT:
                return self._is_attachment(head)
            case Opcode.DATA_END:
                return head.size == DATA_END_BYTES and self._is_chain(at)
        return self._is_chain(at)

    def _is_attachment(self, head: Frame) -> bool:
        try:
            attached = attached_at(self.data.file, head)
            self._effort_bytes -= head.size
            return attached.crc != 0 and is_intact(self.data.file, head, attached)
        except (DamagedError, TruncatedError):
            return False

    def _is_chain(self, at: int) -> bool:
        """Whether records follow each other here, of kinds that may stand outside of a chunk."""
        for _ in range(_CHAIN):
            head = self._head(at)
            if head is None or not self._may_stand_here(head):
                return at == self.data.size
            if head.opcode == Opcode.FOOTER:
                return self.data.at(head.end, len(MAGIC)) == MAGIC
            self._effort_bytes -= head.size
            at = head.end
        return True

    def _may_stand_here(self, head: Frame) -> bool:
        if head.end > self.data.size or head.opcode > max(Opcode):
            return False
        if head.opcode == Opcode.MESSAGE:
            return self._unchunked
        natural = self._natural_size(head.opcode, head.start)
        return natural == head.size


def _is_measured(opcode: int) -> bool:
    return opcode in _FIXED or opcode == Opcode.ATTACHMENT or is_measurable(opcode)


def fields_of(data: FileBytes, frame: Frame) -> bytes:
    """The fields of a record that is not too large.

    Raises:
        DamagedError: the file ends before.
    """
    fields = data.at(frame.body, frame.size)
    if len(fields) < frame.size:
        raise DamagedError("it is cut off")
    return fields
