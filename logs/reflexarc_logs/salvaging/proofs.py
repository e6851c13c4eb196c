"""What proves that a record is what it seems: the CRC of a chunk or attachment, or its fields."""

from mcap.opcode import Opcode
from mcap.records import Chunk

from reflexarc_logs.container.attachments import attached_at, is_intact
from reflexarc_logs.container.chunks import Allowance, content_of, records_in
from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    DamagedError,
    Frame,
    NotReadHereError,
    TruncatedError,
)
from reflexarc_logs.salvaging.own_sizes import own_size

_SEARCHED_TIMES = 4
_LEAST_SEARCHED_BYTES = 64 << 20


class Proofs:
    """Looks into the records of one file, within bounds: a search may try every byte of it."""

    def __init__(self, data: FileBytes) -> None:
        self._data = data
        self.left_bytes = _SEARCHED_TIMES * data.size + _LEAST_SEARCHED_BYTES
        """How much may still be looked at."""

    def chunk_at(self, at: int, end: int) -> Frame | None:
        """The chunk whose fields stand behind this head, whatever it says, up to a known place."""
        size = own_size(self._data, Opcode.CHUNK, at)
        if size is None or self.left_bytes < 0:
            return None
        frame = Frame(Opcode.CHUNK, at, size)
        if frame.end > end:
            return None
        self.left_bytes -= size
        return frame if self.proves(frame) else None

    def proves(self, frame: Frame) -> bool:
        """Whether what stands in a frame is a record of its kind."""
        if frame.end > self._data.size or self.left_bytes < 0:
            return False
        try:
            if frame.opcode == Opcode.ATTACHMENT:
                return self._is_attachment(frame)
            if frame.opcode == Opcode.METADATA:
                return own_size(self._data, frame.opcode, frame.start) == frame.size
            return self._is_chunk(frame)
        except (DamagedError, NotReadHereError, TruncatedError):
            return False

    def _is_chunk(self, frame: Frame) -> bool:
        chunk = decoded(Opcode.CHUNK, self._data.at(frame.body, frame.size))
        if not isinstance(chunk, Chunk):
            return False
        self.left_bytes -= chunk.uncompressed_size
        allowed = Allowance.of(self._data.size)
        content = content_of(chunk, allowed)
        if not chunk.uncompressed_crc:
            return bool(content) and all(True for _ in records_in(content, allowed))
        return True

    def _is_attachment(self, frame: Frame) -> bool:
        attached = attached_at(self._data.file, frame)
        self.left_bytes -= frame.size
        return attached.crc != 0 and is_intact(self._data.file, frame, attached)
