"""Counts the messages of a log by its index, without reading them.

How many: the statistics. When the first and the last of a channel came: the message indexes of the
few chunks that can hold them. Bytes of payload are not in an index.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.records import Channel, Chunk, ChunkIndex, McapRecord, Schema

from reflexarc_logs.container.chunks import Allowance, unpack
from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.frames import FrameReader
from reflexarc_logs.container.index import Index, message_index_at
from reflexarc_logs.reading.topic_counts import TopicCount


def counts_by_index(path: Path, index: Index) -> dict[int, TopicCount]:
    """The count of every channel that has messages; empty where the index does not say enough.

    Raises:
        DamagedError, TruncatedError: the index points to what is not there.
    """
    counts = index.counts or {}
    if not index.chunks or any(number not in index.channels for number in counts):
        return {}
    with path.open("rb") as file:
        return {
            number: _count(file, index, index.channels[number], messages)
            for number, messages in counts.items()
            if messages
        }


def records_of_channels(path: Path, index: Index, channels: set[int]) -> Iterator[McapRecord]:
    """The records of the chunks that hold messages of some channels, in file order."""
    allowance = Allowance.of(path.stat().st_size)
    with path.open("rb") as file:
        for place in _in_file_order(index):
            if channels & place.message_index_offsets.keys():
                yield from _unpacked(file, place, allowance)


def last_chunk_of(path: Path, index: Index, channels: set[int]) -> Iterator[McapRecord]:
    """The records of the last chunk that holds messages of some channels."""
    with path.open("rb") as file:
        for place in reversed(_in_file_order(index)):
            if channels & place.message_index_offsets.keys():
                yield from _unpacked(file, place, Allowance.of(path.stat().st_size))
                return


def _in_file_order(index: Index) -> list[ChunkIndex]:
    return sorted(index.chunks, key=lambda place: place.chunk_start_offset)


def _unpacked(file: BinaryIO, place: ChunkIndex, allowance: Allowance) -> Iterator[McapRecord]:
    reader = FrameReader(
        file, place.chunk_start_offset + place.chunk_length, place.chunk_start_offset
    )
    frame = reader.frame()
    chunk = decoded(frame.opcode, reader.fields(frame))
    if isinstance(chunk, Chunk):
        yield from unpack(chunk, allowance)


def _count(file: BinaryIO, index: Index, channel: Channel, messages: int) -> TopicCount:
    places = [c for c in index.chunks if channel.id in c.message_index_offsets]
    schema = index.schemas.get(channel.schema_id, Schema(0, b"", "", ""))
    first_ns = _earliest(file, places, channel.id)
    last_ns = _latest(file, places, channel.id)
    return TopicCount.of(channel, schema, messages, None, first_ns, last_ns)


def _earliest(file: BinaryIO, places: list[ChunkIndex], channel: int) -> int:
    """Log time of the first message of a channel: no later chunk begins before it."""
    found: int | None = None
    for place in sorted(places, key=lambda place: place.message_start_time):
        if found is not None and place.message_start_time >= found:
            break
        here = min(_times(file, place, channel))
        found = here if found is None else min(found, here)
    return found or 0


def _latest(file: BinaryIO, places: list[ChunkIndex], channel: int) -> int:
    found: int | None = None
    for place in sorted(places, key=lambda place: -place.message_end_time):
        if found is not None and place.message_end_time <= found:
            break
        here = max(_times(file, place, channel))
        found = here if found is None else max(found, here)
    return found or 0


def _times(file: BinaryIO, place: ChunkIndex, channel: int) -> list[int]:
    end = place.chunk_start_offset + place.chunk_length + place.message_index_length
    index = message_index_at(file, place.message_index_offsets[channel], end)
    return [log_ns for log_ns, _ in index.records] or [0]
