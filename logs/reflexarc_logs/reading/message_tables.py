"""The messages of a log as tables: many at once, in file order, without an object for each.

A table is the content of a few chunks, and where in it each message begins and ends. Whoever looks
at most messages only to count them, or compares thousands alike, does it on arrays.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from mcap.opcode import Opcode
from mcap.records import McapRecord, Message

from reflexarc_logs.container.chunks import heads_in
from reflexarc_logs.container.fields import MESSAGE, decoded
from reflexarc_logs.container.frames import HEAD, DamagedError, NotReadHereError
from reflexarc_logs.container.record_stream import ChunkBytes
from reflexarc_logs.reading.channels import Channels, LogStream
from reflexarc_logs.reading.record import Record

TABLE_BYTES = 512 << 10
"""Chunks are put together up to this size: arrays of a few messages cost more than they save."""

Places = npt.NDArray[np.int64]

_HEAD = np.dtype([("channel", "<u2"), ("sequence", "<u4"), ("log_ns", "<u8"), ("sent_ns", "<u8")])
"""What stands in front of a message's payload: `fields.MESSAGE`."""
assert _HEAD.itemsize == MESSAGE.size


@dataclass(frozen=True)
class MessageTable:
    """Messages that follow each other in a log, of channels that are known."""

    content: bytes
    """In which all of them stand."""
    begins: Places
    """Where the fields of each message begin, (messages,)."""
    ends: Places
    """Where its payload ends."""
    streams: dict[int, LogStream]
    """By the channel's number."""
    publish_shift_ns: int = 0
    """How far publish times lie behind the senders' clocks."""

    def __len__(self) -> int:
        return len(self.begins)

    @cached_property
    def data(self) -> npt.NDArray[np.uint8]:
        """The content as an array."""
        return np.frombuffer(self.content, np.uint8)

    @cached_property
    def heads(self) -> npt.NDArray[Any]:
        """Channel, sequence and times of each message, a record of `_HEAD`."""
        windows = np.lib.stride_tricks.sliding_window_view(self.data, _HEAD.itemsize)
        return windows[self.begins].reshape(-1).view(_HEAD)

    @cached_property
    def payloads(self) -> Places:
        """Where the payload of each message begins."""
        return self.begins + MESSAGE.size

    @cached_property
    def counted(self) -> dict[int, int]:
        """Messages of each channel."""
        counts = np.bincount(self.heads["channel"])
        return {int(number): int(counts[number]) for number in np.flatnonzero(counts)}

    def channels(self, is_wanted: Callable[[LogStream], bool]) -> npt.NDArray[np.bool_]:
        """Which messages are of such streams, (messages,)."""
        wanted = np.zeros(max(self.streams, default=0) + 1, np.bool_)
        wanted[[number for number, stream in self.streams.items() if is_wanted(stream)]] = True
        found: npt.NDArray[np.bool_] = wanted[self.heads["channel"]]
        return found

    def payload(self, row: int) -> bytes:
        """The payload of one message."""
        return self.content[self.payloads[row] : self.ends[row]]

    def record(self, row: int) -> Record:
        """One message."""
        channel, sequence, log_ns, sent_ns = MESSAGE.unpack_from(self.content, self.begins[row])
        stream = self.streams[channel]
        times = sequence, log_ns, max(0, sent_ns - self.publish_shift_ns)
        return Record(stream.topic, stream.schema, *times, self.payload(row), stream.sender)


class _Messages(NamedTuple):
    """Messages that follow each other in one piece of bytes."""

    content: bytes
    begins: Places
    """Where the fields of each begin."""
    ends: Places


def tables_of(
    parts: Iterable[McapRecord | ChunkBytes], channels: Channels
) -> Iterator[MessageTable]:
    """The messages of a file as tables, in file order.

    Args:
        parts: of the file.
        channels: those known before; more are learned.

    Raises:
        DamagedError, NotReadHereError: see `record_stream.whole_records`.
        LogError: a message on an unknown channel.
    """
    gathered = _Gathered(channels)
    try:
        for piece in _pieces(parts):
            if isinstance(piece, _Messages):
                gathered.add(piece)
                if gathered.size >= TABLE_BYTES:
                    yield from gathered.tables()
            else:
                yield from gathered.tables()
                channels.learn(piece)
    except (DamagedError, NotReadHereError):
        yield from gathered.tables()  # what stands before the damage
        raise
    yield from gathered.tables()


def _pieces(parts: Iterable[McapRecord | ChunkBytes]) -> Iterator[_Messages | McapRecord]:
    for part in parts:
        if isinstance(part, ChunkBytes):
            yield from _pieces_of_chunk(part)
        elif isinstance(part, Message):
            times = part.sequence, part.log_time, part.publish_time
            content = MESSAGE.pack(part.channel_id, *times) + part.data
            yield _Messages(content, np.array([0]), np.array([len(content)]))
        else:
            yield part


def _pieces_of_chunk(chunk: ChunkBytes) -> Iterator[_Messages | McapRecord]:
    """Its messages up to each schema or channel; of a damaged one those before the damage."""
    content, starts, damage = chunk.content, list[int](), None
    try:
        for some in heads_in(content, chunk.allowance):
            starts += some
    except (DamagedError, NotReadHereError) as error:
        damage = error
    yield from _pieces_at(content, np.array(starts, np.int64), is_whole=damage is None)
    if damage is not None:
        raise damage


def _pieces_at(
    content: bytes, starts: Places, *, is_whole: bool
) -> Iterator[_Messages | McapRecord]:
    """The messages among the records that begin there, and what stands between them."""
    if not len(starts):
        return
    begins, ends = starts + HEAD.size, np.append(starts[1:], len(content))
    if not is_whole:
        ends[-1] = begins[-1] + HEAD.unpack_from(content, starts[-1])[1]
    kinds = np.frombuffer(content, np.uint8)[starts]
    before = 0
    for other in np.flatnonzero(kinds != Opcode.MESSAGE).tolist():
        yield _Messages(content, begins[before:other], ends[before:other])
        before, kind = other + 1, int(kinds[other])
        if not kind:
            raise DamagedError("a chunk: it ends in the middle of a record")
        if kind in (Opcode.SCHEMA, Opcode.CHANNEL):
            record = decoded(kind, content[begins[other] : ends[other]])
            assert record is not None
            yield record
    yield _Messages(content, begins[before:], ends[before:])


class _Gathered:
    """Messages that were put together for a table."""

    def __init__(self, channels: Channels) -> None:
        self.size = 0
        """Bytes of their contents."""
        self._channels = channels
        self._contents: list[bytes] = []
        self._begins: list[Places] = []
        self._ends: list[Places] = []

    def add(self, messages: _Messages) -> None:
        """Take messages."""
        if len(messages.begins):
            self._begins.append(messages.begins + self.size)
            self._ends.append(messages.ends + self.size)
            self._contents.append(messages.content)
            self.size += len(messages.content)

    def tables(self) -> Iterator[MessageTable]:
        """What was taken since the last time.

        Raises:
            DamagedError: a message is shorter than its own fields.
            LogError: a message on an unknown channel.
        """
        if not self._contents:
            return
        content = b"".join(self._contents)
        begins, ends = np.concatenate(self._begins), np.concatenate(self._ends)
        self._contents, self._begins, self._ends, self.size = [], [], [], 0
        short = np.flatnonzero(ends - begins < MESSAGE.size)
        whole = int(short[0]) if len(short) else len(begins)
        yield from self._known(content, begins[:whole], ends[:whole])
        if len(short):
            raise DamagedError("a record shorter than its own fields")

    def _known(self, content: bytes, begins: Places, ends: Places) -> Iterator[MessageTable]:
        """The messages up to one of an unknown channel."""
        streams = dict(self._channels.streams)
        table = MessageTable(content, begins, ends, streams, self._channels.publish_shift_ns)
        if not len(table):
            return
        strange = table.counted.keys() - streams.keys()
        if not strange:
            yield table
            return
        channels = table.heads["channel"]
        first = int(np.flatnonzero(np.isin(channels, [*strange]))[0])
        if first:
            yield MessageTable(
                content, begins[:first], ends[:first], streams, table.publish_shift_ns
            )
        self._channels.of(int(channels[first]))
