"""The chunks' index of a log that is being written, kept small until the end asks for it.

A recording at 1 kHz writes ten chunks a second, each with a record of 120 bytes in the summary: as
objects they would be 800 MB in a day, as bytes 100, compressed 40.
"""

import zlib
from collections.abc import Iterator

_PACKED_AT_BYTES = 1 << 16


class KeptIndex:
    """Records of an index, in their order."""

    def __init__(self) -> None:
        self.count = 0
        self._open = bytearray()
        self._packed: list[bytes] = []

    def add(self, record: bytes) -> None:
        """Keep a record, with its head."""
        self.count += 1
        self._open += record
        if len(self._open) >= _PACKED_AT_BYTES:
            self._packed.append(zlib.compress(self._open))
            self._open.clear()

    def blocks(self) -> Iterator[bytes]:
        """All records, many at once."""
        yield from map(zlib.decompress, self._packed)
        yield bytes(self._open)
