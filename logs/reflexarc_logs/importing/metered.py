"""Streams that count their bytes, so that a small packed file cannot grow without end."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import LogError

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

FREE_BYTES = 1 << 23
"""As much may come out of any packed file."""
MOST_PACKED = 100
"""Lidar logs shrink to a tenth, those of a robot at rest to a fortieth; blank lines to 1/1000."""


class Metered(io.RawIOBase):
    """A stream that counts what was read of it."""

    def __init__(self, stream: io.RawIOBase | io.BufferedIOBase) -> None:
        self.bytes_read = 0
        self._stream = stream

    def readable(self) -> bool:
        """It is read and not written."""
        return True

    def readinto(self, buffer: "WriteableBuffer", /) -> int:
        """Read as much as is there; see `io.RawIOBase`."""
        count = self._stream.readinto(buffer) or 0
        self.bytes_read += count
        return count

    def close(self) -> None:
        """Close what it reads, too."""
        self._stream.close()
        super().close()


class Unpacked(Metered):
    """What comes out of a packed file, as long as it is in proportion to what goes in.

    Args:
        path: of the packed file, for the message.
        stream: what comes out.
        packed: what goes in.
    """

    def __init__(self, path: Path, stream: io.BufferedIOBase, packed: Metered) -> None:
        super().__init__(stream)
        self._path, self._packed = path, packed

    def readinto(self, buffer: "WriteableBuffer", /) -> int:
        """See `Metered.readinto`.

        Raises:
            LogError: out of all proportion.
        """
        count = super().readinto(buffer)
        packed = self._packed.bytes_read
        if self.bytes_read > FREE_BYTES and self.bytes_read > MOST_PACKED * packed:
            raise LogError(
                f"{self._path}: unpacks to more than {MOST_PACKED} times its size, as no lidar log "
                "does; if it is one, unpack it first: gzip -d"
            )
        return count
