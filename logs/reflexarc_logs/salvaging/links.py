"""Whether a record begins at a place of a damaged file, by what stands there and behind it.

A record whose two lengths agree, the one in its head and the one that its fields add up to, is no
accident. A message has only the first; it counts where messages stand outside of chunks at all,
its channel is known, and another record follows.
"""

import re

from mcap.opcode import Opcode

from reflexarc_logs.container.fields import MESSAGE
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    DATA_END_BYTES,
    FOOTER_BYTES,
    HEAD,
    MAGIC,
    MAX_HELD_BYTES,
    Frame,
)
from reflexarc_logs.salvaging.landmarks import Landmarks
from reflexarc_logs.salvaging.own_sizes import own_size

OF_DATA = (
    Opcode.CHUNK,
    Opcode.ATTACHMENT,
    Opcode.MESSAGE_INDEX,
    Opcode.METADATA,
    Opcode.CHANNEL,
    Opcode.SCHEMA,
    Opcode.HEADER,
)
"""What stands in front of the end of the data and says where it ends."""
OF_INDEX = (
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.STATISTICS,
    Opcode.METADATA_INDEX,
    Opcode.SUMMARY_OFFSET,
)
"""What stands behind it only."""
PRIVATE = 0x80
_ENOUGH = 3
"""Points at which a chain of records is no accident: two a message of a known channel, one of an
unknown one or for a record that the format does not know."""
_CUT_BYTES = 1 << 20
"""What ends beyond the file is taken for its last record up to this length."""
_MOST_STEPS = 10_000
_INNER_HEAD = re.compile(rb"(?=[\x03-\x07\x09\x0c].{4}\x00{4})", re.DOTALL)


class Links:
    """Judges places of one file.

    Args:
        data: the file.
        marks: what its index proves.
        channels: numbers that are known; the walk adds those that it meets.
    """

    def __init__(self, data: FileBytes, marks: Landmarks, channels: set[int]) -> None:
        self._data, self._marks, self.channels = data, marks, channels
        self.messages_stand_alone = None if marks.has_chunks is None else not marks.has_chunks
        """Whether messages stand outside of chunks in this file; None: not known yet."""

    def head(self, at: int) -> Frame | None:
        """The kind and the length that a place says; None: the file ends before."""
        head = self._data.at(at, HEAD.size)
        if len(head) < HEAD.size:
            return None
        opcode, size = HEAD.unpack(head)
        return Frame(opcode, at, size)

    def is_exact(self, head: Frame, kind: int) -> bool:
        """Whether the fields, as those of this kind, are as long as the head says."""
        return own_size(self._data, kind, head.start) == head.size

    def is_link(self, at: int, *, behind_message: bool = False) -> bool:
        """Whether a record begins here, or the file ends."""
        points, are_alone = 0, behind_message or self.messages_stand_alone is not False
        while at != self._data.size and not self._marks.has(at):
            head = self.head(at)
            if head is None:
                return points > 0 or self._data.at(at, 1) <= b"\x0f"
            if head.opcode in OF_DATA and self.is_exact(head, head.opcode):
                return True
            if self.is_data_end(head):
                return True
            points += self._points(head)
            if not self._may_stand_here(head, are_alone):
                return False
            if points >= _ENOUGH or head.end > self._data.size:
                return True
            at = head.end
        return True

    def _points(self, head: Frame) -> int:
        return 2 if head.opcode == Opcode.MESSAGE and self.is_known_channel(head) else 1

    def _may_stand_here(self, head: Frame, messages_stand_alone: bool) -> bool:
        is_cut = head.end > self._data.size
        if is_cut and head.size > _CUT_BYTES:
            return False
        if head.opcode == Opcode.MESSAGE:
            is_named = not self.channels or self.is_known_channel(head) or not is_cut
            return messages_stand_alone and head.size >= MESSAGE.size and is_named
        if head.opcode in OF_DATA:
            own = own_size(self._data, head.opcode, head.start)
            return is_cut if own is None else own <= head.size  # a later version may add to it
        return head.opcode >= PRIVATE and not is_cut

    def is_known_channel(self, head: Frame) -> bool:
        """Whether what stands here, taken for a message, is one of a channel that is known."""
        number = self._data.at(head.body, 2)
        return len(number) == 2 and int.from_bytes(number, "little") in self.channels

    def is_data_end(self, head: Frame) -> bool:
        """Whether the data ends here: its kind or its length says so, and an index follows."""
        if self._marks.data_end is not None:
            return head.start == self._marks.data_end
        is_kind, is_length = head.opcode == Opcode.DATA_END, head.size == DATA_END_BYTES
        if not is_kind and not is_length:
            return False
        behind = head.body + DATA_END_BYTES
        if is_kind and is_length:
            following = self.head(behind)
            return following is None or not self._is_data(following)
        return self.is_index(behind)

    def _is_data(self, head: Frame) -> bool:
        """Whether this is surely a record that stands in front of the end of the data only."""
        if head.opcode == Opcode.MESSAGE:
            return head.size >= MESSAGE.size and self.is_link(head.end)
        only = head.opcode in OF_DATA and head.opcode not in (Opcode.CHANNEL, Opcode.SCHEMA)
        return only and self.is_exact(head, head.opcode)

    def is_index(self, at: int) -> bool:
        """Whether nothing but an index and the end of the file stands here."""
        for _ in range(_MOST_STEPS):
            head = self.head(at)
            if head is None or head.end > self._data.size:
                return False
            if head.opcode == Opcode.FOOTER:
                return head.size == FOOTER_BYTES and self._data.at(head.end, len(MAGIC)) == MAGIC
            if head.opcode not in (*OF_INDEX, Opcode.SCHEMA, Opcode.CHANNEL):
                return False
            at = head.end
        return True

    def swallows(self, head: Frame) -> bool:
        """Whether a message is too long by whole records: such stand at the end of its payload."""
        start = head.body + MESSAGE.size
        if not HEAD.size + MESSAGE.size <= head.end - start <= MAX_HELD_BYTES:
            return False
        payload, steps = self._data.at(start, head.end - start), _MOST_STEPS
        for match in _INNER_HEAD.finditer(payload):
            at = match.start()
            while at < len(payload) and steps > 0 and (size := self._inner(start + at)):
                at, steps = at + size, steps - 1
            if at == len(payload) or steps <= 0:
                return steps > 0
            steps -= 1
        return False

    def _inner(self, at: int) -> int:
        """Bytes of what looks like a record inside of another; 0: nothing does."""
        head = self.head(at)
        if head is None or head.end > self._data.size:
            return 0
        is_message = head.opcode == Opcode.MESSAGE and head.size >= MESSAGE.size
        is_named = is_message and self.is_known_channel(head)
        is_other = head.opcode in OF_DATA and self.is_exact(head, head.opcode)
        return HEAD.size + head.size if is_named or is_other else 0
