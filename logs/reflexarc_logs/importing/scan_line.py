"""What one line of a lidar log says, in our terms: metres, radians, nanoseconds.

No return is +inf, an unknown distance is NaN, as `reflexarc_runtime.sensing.retina` reads them;
nothing is guessed.
"""

import math
from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from reflexarc_logs.importing.number_words import has_grouped_digits

MAX_BEAMS = 65_536
"""More would not fit into a message on the bus."""

NO_RETURN = math.inf
UNKNOWN = math.nan

NO_NUMBER = "a pose or a time is no number"
_FIRST_SECOND, _LAST_SECOND = -62_135_596_800, 253_402_300_799
"""Years 1 to 9999: what a protobuf Timestamp may say."""


class BrokenLineError(ValueError):
    """A line that begins as a scan and is none; its message says of which kind it is."""


class TimedPose(NamedTuple):
    """A planar pose at a time of the file."""

    x_m: float
    y_m: float
    heading_rad: float
    time_ns: int | None
    """None where the file's time is no time."""


class Sweep(NamedTuple):
    """One scan with all that its line says. Beams go counter-clockwise."""

    time_ns: int | None
    """The file's own time; None where it is no time."""
    start_rad: float
    end_rad: float
    ranges_m: npt.NDArray[np.float64]
    """Shape (beams,), little-endian."""
    unreadable: int = 0
    """Beams whose word is no number."""
    pose: TimedPose | None = None
    """Corrected, in the world's frame."""
    odometry: TimedPose | None = None


class LineReader(Protocol):
    """Reads the lines of one file of some format, in order."""

    expects: str
    """What lines of this format look like."""
    no_distance: str
    """What a number is called that is no distance and not the absence of a return."""
    blind_beams: int
    """Beams of every scan that say nothing, whatever they give."""

    def sweep(self, line: bytes) -> Sweep | None:
        """The scan of a line; None where it holds something else.

        Args:
            line: with its end, if it has one.

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


def finite(words: Sequence[bytes]) -> list[float]:
    """Finite numbers: metres, radians, seconds.

    Raises:
        BrokenLineError: one is none.
    """
    try:
        values = list(map(float, words))
    except ValueError:
        raise BrokenLineError(NO_NUMBER) from None
    if not math.isfinite(sum(values)) or has_grouped_digits(words):
        raise BrokenLineError(NO_NUMBER)
    return values


def exact_ns(seconds: bytes, value: float) -> int | None:
    """A time, exactly as its decimal digits say; None where no calendar reaches.

    Args:
        seconds: the word.
        value: the same as a number, in seconds; finite.
    """
    if not _FIRST_SECOND <= value < _LAST_SECOND:
        return None
    return round(Decimal(seconds.decode()).scaleb(9))


def calendar_ns(time_ns: int) -> int | None:
    """A time that a protobuf Timestamp can say, or None."""
    return time_ns if _FIRST_SECOND <= time_ns // 1_000_000_000 <= _LAST_SECOND else None
