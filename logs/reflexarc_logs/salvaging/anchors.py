"""Searches a damaged file for the next place where a record proves itself."""

import re

from mcap.opcode import Opcode

from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import HEAD
from reflexarc_logs.salvaging.landmarks import Landmarks
from reflexarc_logs.salvaging.links import OF_DATA, Links
from reflexarc_logs.salvaging.proofs import Proofs

_HEAD_LIKE = re.compile(rb"(?=[\x01-\x0f].{4}\x00{4})", re.DOTALL)
"""A kind that the format has, and a length below 4 GiB."""
_LOOK_BYTES = 4096
"""What a look at one place is counted as: a file in which every byte looks like a beginning ends
the search, and what its index knows is taken."""


class Anchors:
    """The places of one file from which a walk can go on."""

    def __init__(self, data: FileBytes, marks: Landmarks, links: Links, proofs: Proofs) -> None:
        self._data, self._marks, self._links, self._proofs = data, marks, links, proofs
        self._searched, self._found = 0, -1

    def next_from(self, start: int) -> int:
        """The first one from here on; the end of the file if there is none."""
        if not self._searched <= start <= self._found:
            self._searched, self._found = start, self._search(start)
        return self._found

    def _search(self, start: int) -> int:
        if self._marks.has(start):
            return start
        end = self._marks.limit(start, self._data.size)
        for at in self._data.search(_HEAD_LIKE, start, end, HEAD.size):
            if self._proofs.left_bytes < 0:
                break
            before = self._data.bytes_read
            if self._is_anchor(at):
                return at
            self._proofs.left_bytes -= _LOOK_BYTES + self._data.bytes_read - before
        return end

    def _is_anchor(self, at: int) -> bool:
        head = self._links.head(at)
        if head is None or head.end > self._data.size:
            return False
        end = self._marks.limit(at, self._data.size)
        match head.opcode:
            case Opcode.CHUNK:
                is_known = self._marks.has_chunks
                return not is_known and self._proofs.chunk_at(at, end) is not None
            case Opcode.ATTACHMENT:
                return self._proofs.proves(head)
            case Opcode.MESSAGE:
                return self._links.is_link(at)
            case Opcode.DATA_END:
                return self._links.is_data_end(head)
        is_exact = head.opcode in OF_DATA and self._links.is_exact(head, head.opcode)
        return is_exact and head.end <= end and self._links.is_link(head.end)
