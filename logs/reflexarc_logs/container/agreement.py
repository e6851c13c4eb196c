"""Whether the data of an MCAP file is what its own index says, where no CRC of the data tells.

The MCAP library writes none unless it is asked to. A changed kind or length of one record then
leaves a file that reads well, and lacks a chunk or has a message too many. The index says how many
there are of each, where they stand, and what schemas and channels are.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import ChunkIndex, Statistics

from reflexarc_logs.container.frames import HEAD, Frame, check_held
from reflexarc_logs.container.index import Index

_DEFINED = (Opcode.SCHEMA, Opcode.CHANNEL)
_MOST_DEFINITIONS = 1 << 17
"""A file has numbers for half as many channels, and for as many schemas."""


@dataclass
class Passed:
    """What stood in the data outside of chunks, in one pass."""

    kinds: Counter[int] = field(default_factory=Counter)
    definitions: list[Frame] = field(default_factory=list)
    """Schemas and channels."""

    def note(self, frame: Frame) -> None:
        """One more record."""
        self.kinds[frame.opcode] += 1
        if frame.opcode in _DEFINED and len(self.definitions) < _MOST_DEFINITIONS:
            self.definitions.append(frame)


def disagreement(file: BinaryIO, index: Index, passed: Passed) -> str:
    """The first thing that the index says otherwise than the data; empty: they agree.

    Raises:
        NotReadHereError: a schema or a channel is too large to be held.
    """
    counted = "" if index.statistics is None else _miscounted(index.statistics, passed.kinds)
    return counted or next(_misplaced(file, index), "") or _redefined(file, index, passed)


def _miscounted(said: Statistics, kinds: Counter[int]) -> str:
    counts = {
        "chunks": (said.chunk_count, Opcode.CHUNK),
        "attachments": (said.attachment_count, Opcode.ATTACHMENT),
        "metadata records": (said.metadata_count, Opcode.METADATA),
    }
    if not said.chunk_count:
        counts["messages"] = (said.message_count, Opcode.MESSAGE)
        if kinds[Opcode.CHANNEL] < said.channel_count:  # one may stand there twice
            counts["channels"] = (said.channel_count, Opcode.CHANNEL)
        if kinds[Opcode.SCHEMA] < said.schema_count:
            counts["schemas"] = (said.schema_count, Opcode.SCHEMA)
    for what, (count, kind) in counts.items():
        if count != kinds[kind]:
            return f"{kinds[kind]} {what}, but by its own statistics {count}"
    return ""


def _misplaced(file: BinaryIO, index: Index) -> Iterator[str]:
    """Records that the index names, and that do not stand where it says."""
    for what, opcode, start, length in _named(index):
        if _head(file, start) != (opcode, length - HEAD.size):
            yield f"its index names {what} at byte {start}, where none is"
    for chunk in index.chunks:
        if (at := _no_message_index(file, chunk)) is not None:
            yield f"its index names a message index at byte {at}, where none is"


def _named(index: Index) -> Iterator[tuple[str, int, int, int]]:
    for chunk in index.chunks:
        yield "a chunk", Opcode.CHUNK, chunk.chunk_start_offset, chunk.chunk_length
    for attached in index.attachments:
        yield "an attachment", Opcode.ATTACHMENT, attached.offset, attached.length
    for metadata in index.metadata:
        yield "metadata", Opcode.METADATA, metadata.offset, metadata.length


def _no_message_index(file: BinaryIO, chunk: ChunkIndex) -> int | None:
    """Where something else stands among the message indexes of a chunk."""
    at = chunk.chunk_start_offset + chunk.chunk_length
    end = at + chunk.message_index_length
    while at < end:
        opcode, size = _head(file, at)
        if opcode != Opcode.MESSAGE_INDEX or at + HEAD.size + size > end:
            return at
        at += HEAD.size + size
    return None


def _redefined(file: BinaryIO, index: Index, passed: Passed) -> str:
    """Schemas and channels outside of chunks that the index repeats with other fields."""
    for frame in passed.definitions:
        check_held(frame.size)
        file.seek(frame.body)
        fields = file.read(frame.size)
        number = int.from_bytes(fields[:2], "little")
        repeated = index.raw.get((frame.opcode, number))
        if repeated != fields if repeated is not None else _repeats_all(index, frame.opcode):
            what = "schema" if frame.opcode == Opcode.SCHEMA else "channel"
            return f"{what} {number} is not what its index says"
    return ""


def _repeats_all(index: Index, opcode: int) -> bool:
    """Whether the index repeats every schema, or every channel, by its own count."""
    if index.statistics is None:
        return False
    said, known = index.statistics.channel_count, len(index.channels)
    if opcode == Opcode.SCHEMA:
        said, known = index.statistics.schema_count, len(index.schemas)
    return said == known


def _head(file: BinaryIO, at: int) -> tuple[int, int]:
    """Kind and length at a place; (0, 0) where the file has none."""
    if at >= 1 << 62:
        return 0, 0
    file.seek(at)
    head = file.read(HEAD.size)
    return HEAD.unpack(head) if len(head) == HEAD.size else (0, 0)
