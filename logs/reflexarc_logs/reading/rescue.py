"""Copies the records of a salvaged file into a new one, and accounts for those that are lost."""

import struct
from collections.abc import Container, Iterable
from dataclasses import dataclass, field

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, McapRecord, Metadata, Schema

from reflexarc_logs.container.attachments import attached_at, is_intact
from reflexarc_logs.container.chunks import Allowance, content_of, records_in
from reflexarc_logs.container.fields import MESSAGE, decoded
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    HEAD,
    DamagedError,
    Frame,
    NotReadHereError,
    blocks,
    check_held,
)
from reflexarc_logs.container.index import Index
from reflexarc_logs.container.raw_log import ChunkContent, RawLog, index_fields
from reflexarc_logs.container.run_info import RUN
from reflexarc_logs.container.writing import PROFILE
from reflexarc_logs.reading.losses import LossAccount, LossPlace
from reflexarc_logs.reading.nameless import defined_later, nameless_schema, stand_in
from reflexarc_logs.salvaging.links import OF_INDEX
from reflexarc_logs.salvaging.salvage import Found, Hole, fields_of

_LIBRARY = "reflexarc recover"
_INDEX_HEAD = struct.Struct("<HI")
"""Channel of a message index, and the length of its entries."""


@dataclass
class Rescue:
    """Takes what a walk finds, in its order.

    Args:
        data: the broken file.
        file: the new one.
        account: where losses go.
        index: of the broken file, if it has one.
    """

    data: FileBytes
    file: RawLog
    account: LossAccount
    index: Index | None
    is_whole: bool = False
    """Whether the CRC of its data fits, so that nothing needs to be put right."""
    records: int = 0
    """How many were saved, the header aside."""
    is_ours: bool = False
    ends_in_hole: bool = False
    """Whether the file does not end with a whole record."""
    index_differs: bool = False
    """Whether an index behind a chunk is not what it should be; it is made anew."""
    contradictions: int = 0
    """Schemas and channels that an index without a CRC repeats otherwise: one of both changed."""
    nameless: set[int] = field(default_factory=set)
    """Channels whose own record is lost."""
    topics: dict[int, str] = field(default_factory=dict)
    _has_header: bool = False
    _allowance: Allowance = field(init=False)
    _indexed: frozenset[int] = frozenset()
    _expected: dict[int, bytes] = field(default_factory=dict)
    _later: dict[tuple[int, int], bytes] | None = None

    def __post_init__(self) -> None:
        self._allowance = Allowance.of(self.data.size)
        if self.index is not None:
            self.topics = {number: c.topic for number, c in self.index.channels.items()}
            indexed = (c for c in self.index.chunks if c.message_index_offsets)
            self._indexed = frozenset(c.chunk_start_offset for c in indexed)

    def take(self, found: Found) -> None:
        """Copy a record; or account for a hole, or for a record that is not intact."""
        if isinstance(found, Hole):
            self._lose_hole(found)
            return
        try:
            self._copy(found)
        except DamagedError as error:
            self._lose(f"a damaged record ({error})", found.size)
        except NotReadHereError as error:
            self._lose(str(error), found.size)

    def _lose_hole(self, hole: Hole) -> None:
        what, place = "bytes that are no record", None
        if hole.end == self.data.size:
            what, place = "it is cut off in the middle of a record", LossPlace.END
            self.ends_in_hole = True
        self.account.add(what, hole.end - hole.start, self.file.counts.total(), place)

    def _lose(self, what: str, size: int) -> None:
        self.account.add(what, size, self.file.counts.total())

    def _copy(self, frame: Frame) -> None:
        if frame.opcode == Opcode.DATA_END:
            self._begin()
            self._close_chunk()
        elif frame.opcode == Opcode.ATTACHMENT:
            self._copy_attachment(frame)
        elif frame.opcode == Opcode.MESSAGE_INDEX:
            self._hear_index(frame)
        else:
            check_held(frame.size)
            self._copy_fields(frame, fields_of(self.data, frame))

    def _copy_fields(self, frame: Frame, fields: bytes) -> None:
        opcode = frame.opcode
        if opcode == Opcode.HEADER:
            self._copy_header(fields)
            return
        self._begin()
        self._close_chunk()
        if opcode == Opcode.CHUNK:
            self._copy_chunk(frame, fields)
        elif opcode == Opcode.MESSAGE:
            self._copy_message(fields)
        else:
            self._copy_other(opcode, fields, decoded(opcode, fields))
        self.records += 1

    def _begin(self) -> None:
        """Write a header, if the file has lost its own."""
        if not self._has_header:
            self._has_header = True
            fields = b"".join(len(t).to_bytes(4, "little") + t.encode() for t in ("", _LIBRARY))
            self.file.record(Opcode.HEADER, fields)

    def _copy_header(self, fields: bytes) -> None:
        header = decoded(Opcode.HEADER, fields)
        self.is_ours |= isinstance(header, Header) and header.profile == PROFILE
        if not self._has_header:
            self._has_header = True
            self.file.record(Opcode.HEADER, fields)

    def _copy_other(self, opcode: int, fields: bytes, record: McapRecord | None) -> None:
        match record:
            case Schema() | Channel():
                self._learn(*self._as_indexed(record, fields), is_written=True)
            case Metadata():
                self.is_ours |= record.name == RUN
                self.file.metadata(record.name, fields)
            case _ if opcode in (*OF_INDEX, Opcode.FOOTER):
                raise DamagedError("of the index, among the data")
            case _:
                self.file.record(opcode, fields)

    def _learn(
        self,
        record: Schema | Channel,
        fields: bytes,
        *,
        is_written: bool,
        beside: Iterable[McapRecord] = (),
    ) -> None:
        opcode = Opcode.SCHEMA if isinstance(record, Schema) else Opcode.CHANNEL
        if isinstance(record, Channel):
            self.topics[record.id] = record.topic
            self._provide_schema(record.schema_id, {r.id for r in beside if isinstance(r, Schema)})
        self.file.define(opcode, record.id, fields, is_written=is_written)

    def _as_indexed(
        self, record: Schema | Channel, fields: bytes
    ) -> tuple[Schema | Channel, bytes]:
        """A schema or a channel as the index repeats it: that has a CRC, the record itself none."""
        opcode = Opcode.SCHEMA if isinstance(record, Schema) else Opcode.CHANNEL
        raw = None if self.index is None else self.index.raw.get((opcode, record.id))
        repeated = None if raw is None or self.is_whole else decoded(opcode, raw)
        if raw is None or not isinstance(repeated, Schema | Channel) or raw == fields:
            return record, fields
        if self.index is not None and self.index.is_proven:
            return repeated, raw
        self.contradictions += 1
        return record, fields

    def _copy_message(self, fields: bytes) -> None:
        if len(fields) < MESSAGE.size:
            raise DamagedError("a record shorter than its own fields")
        channel, _, log_ns, _ = MESSAGE.unpack_from(fields)
        self._provide(channel)
        self.file.message(channel, log_ns, fields)

    def _copy_chunk(self, frame: Frame, fields: bytes) -> None:
        try:
            chunk = decoded(Opcode.CHUNK, fields)
            assert isinstance(chunk, Chunk)
            content = self._look_into(chunk)
        except DamagedError:
            self.records -= 1
            self._lose("a damaged chunk", len(fields))
            return
        self.file.chunk(_mended(chunk, fields, content), content)
        self._expect_index(frame.start, content)

    def _look_into(self, chunk: Chunk) -> ChunkContent:
        """What a chunk holds; its channels are in the new file from now on."""
        unpacked = content_of(chunk, self._allowance)
        held = ChunkContent(chunk.compression, len(chunk.data), len(unpacked))
        learnt: list[tuple[Schema | Channel, bytes]] = []
        here: set[int] = set()
        used: set[int] = set()
        for opcode, start, end in records_in(unpacked, self._allowance):
            if opcode == Opcode.MESSAGE:
                if end - start < MESSAGE.size:
                    raise DamagedError("a record shorter than its own fields")
                channel, _, log_ns, _ = MESSAGE.unpack_from(unpacked, start)
                if channel not in here:
                    used.add(channel)
                held.add(channel, log_ns, start - HEAD.size)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                fields = unpacked[start:end]
                record = decoded(opcode, fields)
                assert isinstance(record, Schema | Channel)
                learnt.append((record, fields))
                if isinstance(record, Channel):
                    here.add(record.id)
        for channel in sorted(used):
            self._provide(channel)
        for record, fields in learnt:
            self._learn(record, fields, is_written=False, beside=[r for r, _ in learnt])
        return held

    def _copy_attachment(self, frame: Frame) -> None:
        self._begin()
        attached = attached_at(self.data.file, frame)
        if not is_intact(self.data.file, frame, attached):
            what = "an attachment whose CRC does not fit"
            self.account.add(what, frame.size, self.file.counts.total(), counts={})
            return
        self.file.attachment(attached, frame.size, blocks(self.data.file, frame.body, frame.end))
        self.records += 1

    def _hear_index(self, frame: Frame) -> None:
        """A message index is made anew; behind a chunk that is lost it says what is missing."""
        if not self.account.waits and not self._expected:
            return
        fields = fields_of(self.data, frame)
        channel, size = _index_head(fields)
        if size + _INDEX_HEAD.size != len(fields):
            self.index_differs = True
        elif self.account.waits:
            self.account.count(channel, size // 16)
        elif self._expected.pop(channel, fields) != fields:
            self.index_differs = True

    def _close_chunk(self) -> None:
        """The index of the chunk before ends here, and with it what it says."""
        self.account.close()
        self.index_differs |= bool(self._expected)
        self._expected = {}

    def _expect_index(self, start: int, content: ChunkContent) -> None:
        """What the index behind a chunk must say, if the file says that there is one."""
        if start in self._indexed:
            self._expected = {c: index_fields(c, e) for c, e in content.entries.items()}

    def _provide(self, channel: int) -> None:
        """Write the channel of a message, and its schema, if they stood in a part that is lost."""
        if self.file.knows(Opcode.CHANNEL, channel):
            return
        fields = self._defined(Opcode.CHANNEL, channel)
        record = None if fields is None else decoded(Opcode.CHANNEL, fields)
        if fields is None or not isinstance(record, Channel):
            self.nameless.add(channel)
            record, fields = stand_in(channel)
        self._learn(record, fields, is_written=True)

    def _provide_schema(self, number: int, beside: Container[int]) -> None:
        """Write the schema of a channel, if it is lost; a nameless one, if it is nowhere else."""
        if number and number not in beside and not self.file.knows(Opcode.SCHEMA, number):
            fields = self._defined(Opcode.SCHEMA, number)
            if fields is None:
                fields = nameless_schema(number)
            self.file.define(Opcode.SCHEMA, number, fields)

    def _defined(self, opcode: int, number: int) -> bytes | None:
        """The fields of a schema or a channel as they stand elsewhere in the file."""
        if self.index is not None and (opcode, number) in self.index.raw:
            return self.index.raw[opcode, number]
        if self._later is None:
            self._later = defined_later(self.data)
        return self._later.get((opcode, number))


def _index_head(fields: bytes) -> tuple[int, int]:
    """Channel and length of a message index; a length of −1, where there is none."""
    return _INDEX_HEAD.unpack_from(fields) if len(fields) >= _INDEX_HEAD.size else (0, -1)


def _mended(chunk: Chunk, fields: bytes, content: ChunkContent) -> bytes:
    """The fields of a chunk; its two times stand outside of its CRC, and are put right."""
    times = content.first_ns.to_bytes(8, "little") + content.last_ns.to_bytes(8, "little")
    if content.entries and (chunk.message_start_time, chunk.message_end_time) != (
        content.first_ns,
        content.last_ns,
    ):
        return times + fields[16:]
    return fields
