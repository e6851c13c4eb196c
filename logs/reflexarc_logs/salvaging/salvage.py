"""Finds the records of a damaged MCAP file, also behind the place where their chain breaks.

A record tells more than once what it is: its head says kind and length, its fields add up to a
length or to a CRC, what follows begins where it ends, and the index at the end of the file, which
has a CRC of its own, names the places of most. One of them may be wrong, and the others still tell.
Where they do not, the next thing that proves itself is searched for. What is skipped on the way is
a hole.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from mcap.opcode import Opcode

from reflexarc_logs.container.fields import MESSAGE
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    DATA_END_BYTES,
    MAGIC,
    DamagedError,
    Frame,
)
from reflexarc_logs.container.index import Index
from reflexarc_logs.salvaging.anchors import Anchors
from reflexarc_logs.salvaging.landmarks import Landmarks
from reflexarc_logs.salvaging.links import OF_DATA, OF_INDEX, PRIVATE, Links
from reflexarc_logs.salvaging.own_sizes import is_measured, own_size
from reflexarc_logs.salvaging.proofs import Proofs

_INDEXED_ALONE = (Opcode.CHUNK, Opcode.MESSAGE_INDEX)


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
        index: what it says of itself; None: nothing.
    """

    data: FileBytes
    is_whole: bool
    index: Index | None
    end: int = 0
    """Where the walk is; at last, where the data ended."""
    has_ended: bool = False
    """Whether the end of the data was found."""
    in_doubt: int = 0
    """Records of no kind that the format knows, which may be messages whose kind was changed."""
    _before: int = 0
    """Kind of the record before."""
    _marks: Landmarks = field(init=False)
    _links: Links = field(init=False)
    _proofs: Proofs = field(init=False)
    _anchors: Anchors = field(init=False)

    def __post_init__(self) -> None:
        self._proofs = Proofs(self.data)
        self._marks = Landmarks()
        if not self.is_whole:
            self._marks = Landmarks.of(self.index, self.data, self._proofs.proves)
        channels = set() if self.index is None else set(self.index.channels)
        self._links = Links(self.data, self._marks, channels)
        self._anchors = Anchors(self.data, self._marks, self._links, self._proofs)

    def walk(self) -> Iterator[Found]:
        """Records and holes in the order of the file."""
        self.end = self._beginning()
        if self.end > len(MAGIC):
            yield Hole(0, self.end)
        while self.end < self.data.size and not self.has_ended:
            frame = self._record(self.end)
            if frame is None and (self.has_ended or self._ends_unsaid(self.end)):
                self.has_ended = True
                return
            if frame is None:
                self._note_broken(self.end)
                start, self.end = self.end, self._anchors.next_from(self.end + 1)
                yield Hole(start, self.end)
                continue
            self._note(frame)
            self.end = frame.end
            yield frame

    def _note(self, frame: Frame) -> None:
        self._before = frame.opcode
        self.has_ended = frame.opcode == Opcode.DATA_END
        if frame.opcode == Opcode.CHANNEL:
            number = self.data.at(frame.body, 2)
            self._links.channels.add(int.from_bytes(number, "little"))
        elif frame.opcode == Opcode.MESSAGE:
            self._links.messages_stand_alone = True
        elif frame.opcode == Opcode.CHUNK and self._links.messages_stand_alone is None:
            self._links.messages_stand_alone = False

    def _note_broken(self, at: int) -> None:
        """What calls itself a chunk and is none: what is inside of it stands not for itself."""
        head = self._links.head(at)
        if head is not None and head.opcode == Opcode.CHUNK:
            self._links.messages_stand_alone = self._links.messages_stand_alone or False

    def _beginning(self) -> int:
        """Where the first record is; a file may have lost its first bytes."""
        if self.data.at(0, len(MAGIC)) == MAGIC or self._links.is_link(len(MAGIC)):
            return len(MAGIC)
        return self._anchors.next_from(0)

    def _ends_unsaid(self, at: int) -> bool:
        """Whether the index begins here, and the end of the data before it is lost."""
        head = self._links.head(at)
        return head is not None and head.opcode in OF_INDEX and self._links.is_index(at)

    def _record(self, at: int) -> Frame | None:
        """The record at a place, with its true kind and length; None: there is none."""
        head = self._links.head(at)
        if head is None:
            return None
        if self.is_whole:
            return head if head.opcode and head.end <= self.data.size else None
        if (known := self._marks.frames.get(at)) is not None:
            return known
        if self._links.is_data_end(head):
            return Frame(Opcode.DATA_END, at, DATA_END_BYTES)
        return self._as_told(head) or self._of_another_kind(head) or self._one_sided(head)

    def _as_told(self, head: Frame) -> Frame | None:
        """A record of the kind that its head says, if its fields say the same length."""
        is_exact = head.opcode in OF_DATA and self._links.is_exact(head, head.opcode)
        return head if is_exact and self._fits_in(head) else None

    def _of_another_kind(self, head: Frame) -> Frame | None:
        """A record whose length is right, and whose kind is not; or a chunk of any length."""
        for kind in OF_DATA:
            if kind != head.opcode and self._links.is_exact(head, kind):
                frame = Frame(kind, head.start, head.size)
                if self._fits_in(frame) and self._is_changed_to(head.opcode, frame):
                    return frame
        limit = self._marks.limit(head.start, self.data.size)
        chunk = self._proofs.chunk_at(head.start, limit)
        is_padded = chunk is not None and head.opcode == Opcode.CHUNK and chunk.size < head.size
        return self._longer_or_shorter(head, chunk) if chunk and is_padded else chunk

    def _is_changed_to(self, told: int, frame: Frame) -> bool:
        """Whether a record that calls itself something else is of this kind in truth."""
        match frame.opcode:
            case Opcode.CHUNK:
                return self._proofs.proves(frame)
            case Opcode.ATTACHMENT:
                return self._proofs.proves(frame)
            case Opcode.MESSAGE_INDEX:
                return self._before in _INDEXED_ALONE
            case Opcode.HEADER:
                return frame.start == len(MAGIC)
        return (told ^ frame.opcode).bit_count() == 1

    def _one_sided(self, head: Frame) -> Frame | None:
        """A record of which only one length makes sense: the one behind which another follows."""
        if head.opcode == Opcode.MESSAGE:
            is_one = head.size >= MESSAGE.size and self._is_followed(head)
            return head if is_one and not self._links.swallows(head) else None
        if not is_measured(head.opcode):
            return self._unknown(head)
        if head.opcode not in OF_DATA:
            return None
        own = own_size(self.data, head.opcode, head.start)
        if own is None:
            return head if self._is_followed(head) else None
        return self._longer_or_shorter(head, Frame(head.opcode, head.start, own))

    def _longer_or_shorter(self, head: Frame, own: Frame) -> Frame | None:
        """Of two lengths the one behind which a record follows.

        If it does behind both, the shorter: the longer one has taken in whole records. Where a
        later version of the format adds to a record, no record begins behind the shorter.
        """
        both = sorted((head, own), key=lambda frame: frame.end)
        for frame in both:
            if self._fits_in(frame) and self._links.is_link(frame.end):
                return frame
        if own.opcode == Opcode.ATTACHMENT and self._proofs.proves(own):
            return own
        return next((frame for frame in (head, own) if self._is_followed(frame)), None)

    def _unknown(self, head: Frame) -> Frame | None:
        """A record that the format does not know, to be kept as it is."""
        if not head.opcode or not self._is_followed(head):
            return None
        as_message = (head.opcode ^ Opcode.MESSAGE).bit_count() == 1
        if as_message and head.size >= MESSAGE.size and self._links.is_known_channel(head):
            if head.opcode < PRIVATE:
                return None
            self.in_doubt += 1
        return head

    def _fits_in(self, frame: Frame) -> bool:
        return frame.end <= self._marks.limit(frame.start, self.data.size)

    def _is_followed(self, frame: Frame) -> bool:
        """Whether a record begins behind this one, be it one that is damaged."""
        if not self._fits_in(frame):
            return False
        is_message = frame.opcode == Opcode.MESSAGE
        return self._links.is_link(frame.end, behind_message=is_message) or self._is_one_damaged(
            frame.end, self._anchors.next_from(frame.end)
        )

    def _is_one_damaged(self, start: int, end: int) -> bool:
        """Whether a part of the file looks like one record that is damaged in its head."""
        head = self._links.head(start)
        if head is None or start == end:
            return start == end
        are_alone = self._links.messages_stand_alone
        if head.opcode == Opcode.MESSAGE and are_alone and self._links.is_known_channel(head):
            return True
        size = end - head.body
        return head.size == size or any(own_size(self.data, k, start) == size for k in OF_DATA)


def fields_of(data: FileBytes, frame: Frame) -> bytes:
    """The fields of a record that is not too large.

    Raises:
        DamagedError: the file ends before.
    """
    fields = data.at(frame.body, frame.size)
    if len(fields) < frame.size:
        raise DamagedError("it is cut off")
    return fields
