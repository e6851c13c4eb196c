"""What one line of a lidar log says, in our terms: metres, radians, nanoseconds.

No return is +inf, and whatever says nothing is NaN, as `reflexarc_runtime.retina` reads them;
nothing is guessed.
"""

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Protocol

import numpy as np
import numpy.typing as npt

MAX_BEAMS = 65_536
"""More would not fit into a message on the bus."""

NO_RETURN = math.inf
UNKNOWN = math.nan

_MAX_REMEMBERED = 65_536
_FLOAT64 = struct.Struct("<d")
_NO_NUMBER = "a pose or a time is no number"
_FIRST_SECOND, _LAST_SECOND = -62_135_596_800, 253_402_300_799
"""Years 1 to 9999: what a protobuf Timestamp may say."""


class BrokenLineError(ValueError):
    """A line that begins as a scan and is none; its message says of which kind it is."""


@dataclass(frozen=True, slots=True)
class Place:
    """A planar pose at a time of the file."""

    x_m: float
    y_m: float
    heading_rad: float
    time_ns: int | None
    """None where the file's time is no time."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """One scan with all that its line says. Beams go counter-clockwise."""

    time_ns: int | None
    """The file's own time; None where it is no time."""
    start_rad: float
    end_rad: float
    ranges_m: npt.NDArray[np.float64]
    """Shape (beams,), little-endian."""
    pose: Place | None = None
    """Corrected, in the world's frame."""
    odometry: Place | None = None


class LineReader(Protocol):
    """Reads the lines of one file of some format, in order."""

    expects: str
    """What lines of this format look like."""
    no_distance: str
    """What a number is called that is no distance and not the absence of a return."""
    blind_beams: int
    """Beams of every scan that say nothing, whatever they give."""
    distances: "Distances"

    def sweep(self, line: bytes) -> Sweep | None:
        """The scan of a line; None where it holds something else.

        Raises:
            BrokenLineError: it begins as a scan and is none, or is no line of this format.
        """
        ...

    def passed_over(self) -> dict[str, int]:
        """Good lines that carry no scan, by keyword."""
        ...

    def notes(self) -> tuple[str, ...]:
        """What a reader of the log should know."""
        ...


class Distances(dict[bytes, bytes]):
    """What each word of a log means as a distance, remembered: logs repeat their few values.

    It is remembered as the eight bytes of a little-endian float64, so that joining them makes the
    array of a scan, which is what a message holds too: no number is made on the way.

    Args:
        meaning: distance in metres, `NO_RETURN` or `UNKNOWN` of a word; ValueError where it is
            no number.
    """

    def __init__(self, meaning: Callable[[bytes], float]) -> None:
        self._meaning = meaning
        self.unreadable = 0
        """Words that were no number; unknown."""

    def __missing__(self, word: bytes) -> bytes:
        try:
            packed = _FLOAT64.pack(self._meaning(word))
        except ValueError:
            self.unreadable += 1
            return _FLOAT64.pack(UNKNOWN)
        if len(self) < _MAX_REMEMBERED:
            self[word] = packed
        return packed

    def of(self, words: Sequence[bytes]) -> npt.NDArray[np.float64]:
        """The distances of many words, in metres, shape (words,)."""
        return np.frombuffer(b"".join(map(self.__getitem__, words)), "<f8")


def place(words: Sequence[bytes], time_ns: int | None) -> Place:
    """A place out of x, y (m) and heading (rad).

    Raises:
        BrokenLineError: one of the three is no number.
    """
    x_m, y_m, heading_rad = _finite(words)
    return Place(x_m, y_m, heading_rad, time_ns)


def nanoseconds(seconds: bytes) -> int | None:
    """A time, exactly as its decimal digits say; None where no calendar reaches.

    Raises:
        BrokenLineError: it is no number.
    """
    (value,) = _finite([seconds])
    if not _FIRST_SECOND <= value < _LAST_SECOND:
        return None
    return round(Decimal(seconds.decode()).scaleb(9))


def calendar_ns(time_ns: int) -> int | None:
    """A time that a protobuf Timestamp can say, or None."""
    return time_ns if _FIRST_SECOND <= time_ns // 1_000_000_000 <= _LAST_SECOND else None


def plain(word: bytes) -> bytes:
    """The word, if no digit of it is grouped as only Python's are.

    Raises:
        ValueError: it is grouped.
    """
    if b"_" in word:
        raise ValueError(word)
    return word


def _finite(words: Sequence[bytes]) -> list[float]:
    """Finite numbers.

    Raises:
        BrokenLineError: one is none.
    """
    try:
        values = list(map(float, words))
    except ValueError:
        raise BrokenLineError(_NO_NUMBER) from None
    if not math.isfinite(sum(values)) or b"_" in b"".join(words):
        raise BrokenLineError(_NO_NUMBER)
    return values
