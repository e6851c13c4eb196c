"""Any part of a file by its offset, for a reader that jumps."""

import os
import re
from collections.abc import Iterator
from typing import BinaryIO

_BLOCK_BYTES = 1 << 20
_MOST_AT_ONCE_BYTES = 128 << 20


class FileBytes:
    """An open file as bytes by their offset; beyond its end are none."""

    def __init__(self, file: BinaryIO) -> None:
        self.file = file
        self.size = os.fstat(file.fileno()).st_size
        self.bytes_read = 0
        """What all looks at it have cost."""

    def at(self, offset: int, count: int) -> bytes:
        """The bytes at a place; fewer at the end of the file."""
        if offset >= self.size:
            return b""
        self.file.seek(offset)
        data = self.file.read(max(min(count, self.size - offset, _MOST_AT_ONCE_BYTES), 0))
        self.bytes_read += len(data)
        return data

    def source(self, offset: int) -> "ForwardBytes":
        """What can be read from a place on."""
        return ForwardBytes(self, offset)

    def search(
        self, pattern: re.Pattern[bytes], start: int, end: int, length: int
    ) -> Iterator[int]:
        """Offsets before `end` at which a pattern of at most `length` bytes matches, in order."""
        for offset in range(start, end, _BLOCK_BYTES):
            block = self.at(offset, min(_BLOCK_BYTES, end - offset) + length - 1)
            if block.count(0) == len(block):
                continue  # a hole, where nothing begins
            for match in pattern.finditer(block):
                if match.start() < _BLOCK_BYTES:
                    yield offset + match.start()


class ForwardBytes:
    """Reads forward from a place."""

    def __init__(self, data: FileBytes, offset: int) -> None:
        self._data = data
        self._offset = offset

    def read(self, count: int, /) -> bytes:
        """The next bytes; none, if there are not so many."""
        if count > self._data.size - self._offset:
            return b""
        taken = self._data.at(self._offset, count)
        self._offset += len(taken)
        return taken
