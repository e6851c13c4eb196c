"""How a chunk is compressed: zstd, thoroughly or quickly.

On a drive of 50 Hz level 15 leaves a tenth less than the library's level 3, at 15 MB a second
instead of 700; level 19 takes four times as long for less than another percent (docs/figures.md).
The compressor holds no lock of the interpreter while it works.
"""

import time
from collections.abc import Callable
from typing import Protocol

import zstandard

ZSTD = "zstd"
THOROUGH_LEVEL = 15
QUICK_LEVEL = 3
"""What zstd and the MCAP library's writer do by default."""
MOST_SHARE = 0.02
"""Of the time: a drive of 50 Hz takes 0.003, 5,000 messages a second would take 0.08."""
MOST_SAVED_S = 0.1
"""Time that was not used so far, and may be used at once."""


class Compressor(Protocol):
    """Compresses chunks for `ZSTD`, one after the other."""

    def compress(self, data: bytes) -> bytes:
        """One chunk."""
        ...


class FixedCompressor:
    """The same for every chunk: the same messages give the same bytes.

    Args:
        level: of zstd.
    """

    def __init__(self, level: int = THOROUGH_LEVEL) -> None:
        self._zstd = zstandard.ZstdCompressor(level=level)

    def compress(self, data: bytes) -> bytes:
        """See `Compressor.compress`."""
        return self._zstd.compress(data)


class ThriftyCompressor:
    """Thorough as long as that takes little of the time, else quick.

    Whatever comes in, a recorder must not take a core from the loop beside it.

    Args:
        now_s: the time.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self._thorough, self._quick = FixedCompressor(), FixedCompressor(QUICK_LEVEL)
        self._now_s = now_s
        self._saved_s = MOST_SAVED_S
        self._before_s = now_s()

    def compress(self, data: bytes) -> bytes:
        """See `Compressor.compress`."""
        begun_s = self._now_s()
        earned_s = MOST_SHARE * (begun_s - self._before_s)
        self._saved_s = min(MOST_SAVED_S, self._saved_s + earned_s)
        self._before_s = begun_s
        if self._saved_s <= 0.0:
            return self._quick.compress(data)
        compressed = self._thorough.compress(data)
        self._saved_s -= self._now_s() - begun_s
        return compressed
