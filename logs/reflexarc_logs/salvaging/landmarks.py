"""What the index of a file proves of its data: where chunks, attachments and metadata stand.

The index has a CRC of its own, so what it says of the data holds though the data is damaged, if
what stands there is what it names.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from mcap.opcode import Opcode

from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import DATA_END_BYTES, HEAD, Frame
from reflexarc_logs.container.index import Index

Proof = Callable[[Frame], bool]
"""Whether what stands in a frame proves that it is such a record, whatever its head says."""


@dataclass
class Landmarks:
    """Places of a file that are known before it is read."""

    frames: dict[int, Frame] = field(default_factory=dict)
    """Records by their first byte."""
    index_ends: dict[int, int] = field(default_factory=dict)
    """Where the message indexes of a chunk end, by where they begin."""
    data_end: int | None = None
    """Where the end of the data stands."""
    has_chunks: bool | None = None
    """Whether the index names chunks; None: there is no index."""
    _places: list[int] = field(default_factory=list)

    @classmethod
    def of(cls, index: Index | None, data: FileBytes, proof: Proof) -> "Landmarks":
        """What an index says, as far as it is so."""
        marks = cls()
        if index is None or index.is_shifted:
            return marks
        for frame in _frames(index):
            if frame.size > 0 and frame.end <= index.start and _holds(data, frame, proof):
                marks.frames[frame.start] = frame
        for chunk in index.chunks:
            end = chunk.chunk_start_offset + chunk.chunk_length
            if chunk.chunk_start_offset in marks.frames and chunk.message_index_length:
                marks.index_ends[end] = min(end + chunk.message_index_length, index.start)
        data_end = Frame(Opcode.DATA_END, index.start - HEAD.size - DATA_END_BYTES, DATA_END_BYTES)
        if is_half_right(data, data_end):
            marks.data_end = data_end.start
        marks.has_chunks = any(f.opcode == Opcode.CHUNK for f in marks.frames.values())
        marks._sort()
        return marks

    def _sort(self) -> None:
        places = {*self.frames, *self.index_ends, *self.index_ends.values()}
        if self.data_end is not None:
            places.add(self.data_end)
        self._places = sorted(places)

    def limit(self, at: int, size: int) -> int:
        """The first known place behind this one, or the end of the file: no record reaches over."""
        following = bisect_right(self._places, at)
        return self._places[following] if following < len(self._places) else size

    def has(self, at: int) -> bool:
        """Whether something is known to begin here."""
        following = bisect_right(self._places, at)
        return following > 0 and self._places[following - 1] == at


def _frames(index: Index) -> Iterable[Frame]:
    head = HEAD.size
    for chunk in index.chunks:
        yield Frame(Opcode.CHUNK, chunk.chunk_start_offset, chunk.chunk_length - head)
    for attached in index.attachments:
        yield Frame(Opcode.ATTACHMENT, attached.offset, attached.length - head)
    for metadata in index.metadata:
        yield Frame(Opcode.METADATA, metadata.offset, metadata.length - head)


def _holds(data: FileBytes, frame: Frame, proof: Proof) -> bool:
    told = data.at(frame.start, HEAD.size)
    return told == HEAD.pack(frame.opcode, frame.size) or proof(frame)


def is_half_right(data: FileBytes, frame: Frame) -> bool:
    """Whether its kind or its length, or both, are those of such a record."""
    head = data.at(frame.start, HEAD.size) if frame.start > 0 else b""
    if len(head) < HEAD.size:
        return False
    opcode, size = HEAD.unpack(head)
    return bool(opcode == frame.opcode or size == frame.size)
