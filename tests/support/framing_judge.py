"""What is wrong with the recovery and the reading of a log with one bit of its framing turned.

The judge is the MCAP library: it reads the whole log and the recovered one; what the two must have
in common follows from which record was hit.
"""

from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk

from reflexarc_logs.checking.byte_checks import index_findings
from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.frames import DamagedError, NotReadHereError
from reflexarc_logs.container.record_stream import whole_records
from reflexarc_logs.container.writing import END
from reflexarc_logs.reading.recover import Recovered, recover
from reflexarc_runtime.errors import LogError
from support.framing_logs import MAGIC, Piece, framing, pieces


class Item(NamedTuple):
    """Something that a log holds: a message and its topic, an attachment, metadata."""

    what: str
    fields: bytes


Items = Counter[Item]


@dataclass(frozen=True)
class Flip:
    """One bit of one byte."""

    at: int
    bit: int
    piece: Piece

    def __str__(self) -> str:
        inside = self.at - self.piece.start
        return f"bit {self.bit} of byte {self.at} (byte {inside} of a record {self.piece.kind})"

    def of(self, data: bytes) -> bytes:
        """The bytes with that bit turned."""
        turned = bytes([data[self.at] ^ 1 << self.bit])
        return data[: self.at] + turned + data[self.at + 1 :]


class FramingJudge:
    """Tries flips on one log.

    Args:
        path: the whole log, of any system.
        scratch: a folder for the broken ones.
    """

    def __init__(self, path: Path, scratch: Path) -> None:
        self.data = path.read_bytes()
        self._broken, self._saved = scratch / "broken.mcap", scratch / "saved.mcap"
        self._held = dict(_by_record(path))
        self._all: Items = sum(self._held.values(), Counter())
        self._summary_start = max(p.end for p in pieces(self.data) if p.kind == _DATA_END)
        self._has_data_crc = self.data[self._summary_start - 4 : self._summary_start] != bytes(4)
        self._has_footer_crc = self.data[-len(MAGIC) - 4 : -len(MAGIC)] != bytes(4)
        self.statuses: Counter[str] = Counter()

    def flips(self) -> Iterator[Flip]:
        """Every bit of every byte of its framing."""
        for piece in pieces(self.data):
            for at in framing(self.data, piece):
                yield from (Flip(at, bit, piece) for bit in range(8))

    def faults(self, flip: Flip) -> list[str]:
        """What is treated wrongly, in words."""
        self._broken.write_bytes(flip.of(self.data))
        return [*self._recovery(flip), *self._reading(flip)]

    def _recovery(self, flip: Flip) -> Iterator[str]:
        self._saved.unlink(missing_ok=True)
        intact = self._all - self._held.get(flip.piece.start, Counter())
        try:
            recovered = recover(self._broken, self._saved)
        except LogError as error:
            self.statuses["2"] += 1
            if intact:
                yield f"refused: {error}"
            return
        self.statuses[str(recovered.exit_status)] += 1
        yield from self._differences(flip, intact, recovered)

    def _differences(self, flip: Flip, intact: Items, recovered: Recovered) -> Iterator[str]:
        got = _items(self._saved)
        if self._cannot_be_known(flip) and recovered.exit_status:
            if invented := _nameless(got) - _nameless(self._all):
                yield f"{invented.total()} invented"
            return
        if lost := intact - got:
            yield f"{lost.total()} intact lost: {next(iter(lost)).what}"
        invented = got - self._all
        mine = self._held.get(flip.piece.start, Counter[Item]())
        if invented and not self._is_the_hit_one(flip, mine, invented, recovered.exit_status):
            yield f"{invented.total()} invented: {next(iter(invented)).what}"
        if self._all - got and not recovered.exit_status and not (mine and invented):
            yield "missing, and status 0"
        by_index = _by_the_librarys_index(self._saved)
        if by_index != sum(n for item, n in got.items() if item.what.startswith("message")):
            yield f"its new index leads to {by_index} messages"

    def _cannot_be_known(self, flip: Flip) -> bool:
        """Whether what was hit says of which topic messages are, in a file without any CRC."""
        is_field = flip.piece.kind == _CHANNEL and flip.at >= flip.piece.start + 9
        return is_field and not self._has_footer_crc and not self._has_data_crc

    def _is_the_hit_one(self, flip: Flip, mine: Items, invented: Items, status: int) -> bool:
        """Whether what is new is the record that was hit, which has no CRC of its own.

        A file with a CRC over its data must say that it is in doubt; one without cannot know.
        """
        is_field = flip.at >= flip.piece.start + 9
        kept = flip.piece.kind in (_MESSAGE, _METADATA) and is_field
        return kept and invented.total() == mine.total() and bool(status or not self._has_data_crc)

    def _reading(self, flip: Flip) -> Iterator[str]:
        found = look(self._broken)
        if not found.complete:
            return
        is_data = flip.at < self._summary_start
        has_crc = self._has_data_crc if is_data else self._has_footer_crc
        if has_crc:
            yield "called whole, against its own CRC"
            return
        with suppress(DamagedError, NotReadHereError):
            got = _messages([*whole_records(found.path, found.intact_size, found.size)])
            if list(index_findings(found.path, got.total())):
                return
            wanted = Counter({i: n for i, n in self._all.items() if i.what.startswith("message")})
            is_kept = flip.piece.kind == _MESSAGE and flip.at >= flip.piece.start + 9
            if got != wanted and not (is_kept and (got - wanted).total() == 1):
                yield "called whole, and read as something else"


_CHANNEL, _MESSAGE, _METADATA, _DATA_END = 4, 5, 12, 15


def _by_record(path: Path) -> Iterator[tuple[int, Items]]:
    """Where each record of the data begins, and what it holds."""
    topics: dict[int, str] = {}
    at = len(MAGIC)
    with path.open("rb") as file:
        for record in StreamReader(file, emit_chunks=True).records:
            if isinstance(record, DataEnd):
                return
            inside = breakup_chunk(record, True) if isinstance(record, Chunk) else [record]
            yield at, _all_of(inside, topics)
            at = file.tell()


def _items(path: Path) -> Items:
    with path.open("rb") as file:
        records: list[McapRecord] = []
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, DataEnd):
                break
            records.append(record)
    return _all_of(records, {})


def _all_of(records: list[McapRecord], topics: dict[int, str]) -> Items:
    held: Items = _messages(records, topics)
    for record in records:
        if isinstance(record, Attachment):
            fields = repr((record.log_time, record.create_time, record.media_type, record.data))
            held[Item(f"attachment {record.name}", fields.encode())] += 1
        elif isinstance(record, Metadata) and record.name != END:
            fields = repr(sorted(record.metadata.items()))
            held[Item(f"metadata {record.name}", fields.encode())] += 1
    return held


def _messages(records: list[McapRecord], topics: dict[int, str] | None = None) -> Items:
    topics = {} if topics is None else topics
    held: Items = Counter()
    for record in records:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            times = repr((record.sequence, record.log_time, record.publish_time))
            topic = topics.get(record.channel_id, "/no channel")
            held[Item(f"message {topic}", times.encode() + record.data)] += 1
    return held


def _nameless(items: Items) -> Counter[bytes]:
    return Counter({item.fields: n for item, n in items.items() if item.what.startswith("message")})


def _by_the_librarys_index(path: Path) -> int:
    with path.open("rb") as file:
        return sum(1 for _ in make_reader(file, validate_crcs=True).iter_messages())
