"""One line of a lidar log, converted to metres, radians and nanoseconds.

"No return" is +inf and an unknown distance is NaN, as `reflexarc_runtime.sensing.retina` expects
them. Nothing is guessed.
"""

import math
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from reflexarc_logs.importing.number_words import has_grouped_digits
from reflexarc_runtime.sensing.mounting import CENTRED, Mount

MAX_BEAMS = 65_536
"""More beams would not fit into a message on the bus."""

NO_RETURN = math.inf
UNKNOWN = math.nan

NO_NUMBER = "a pose or a time is no number"
DECIMAL_COMMA = f"{NO_NUMBER}, but has a decimal comma"
_FIRST_SECOND, _LAST_SECOND = -62_135_596_800, 253_402_300_799
"""Years 1 to 9999: the range of a protobuf Timestamp."""


class BrokenLineError(ValueError):
    """A line that begins like a scan but is malformed; the message names the kind of fault."""


class TimedPose(NamedTuple):
    """A planar pose and when the robot had it, on the clock of the file."""

    x_m: float
    y_m: float
    heading_rad: float
    time_ns: int | None
    """None if no calendar has the file's time."""


class Sweep(NamedTuple):
    """One scan and the poses on its line. Beams go counter-clockwise."""

    time_ns: int | None
    """The file's own time; None if no calendar has it."""
    start_rad: float
    end_rad: float
    ranges_m: npt.NDArray[np.float64]
    """Shape (beams,), little-endian."""
    unreadable: int = 0
    """How many beams have a word that is no number."""
    pose: TimedPose | None = None
    """Corrected, in the world's frame."""
    odometry: TimedPose | None = None
    mount: Mount = CENTRED
    """How the scanner sits on the robot."""


class LineReader(Protocol):
    """Reads the lines of one file of some format, in order."""

    expects: str
    """What lines of this format look like."""
    no_distance: str
    """The report's name for numbers that are neither a distance nor "no return"."""
    blind_beams: int
    """How many beams of every scan are ignored, whatever their value."""

    def foresee(self, lines: list[bytes]) -> None:
        """Look at the beginning of the file, some megabytes of it, before the first line is read.

        Args:
            lines: with their ends.
        """
        ...

    def sweep(self, line: bytes) -> Sweep | None:
        """The scan of a line; None if the line holds something else.

        Args:
            line: with its end, if it has one.

        Raises:
            BrokenLineError: it begins like a scan but is malformed, or has an unknown keyword.
        """
        ...

    def passed_over(self) -> dict[str, int]:
        """How many well-formed lines carry no scan, by keyword."""
        ...

    def notes(self) -> tuple[str, ...]:
        """Remarks for the user about the whole file."""
        ...


def finite(words: Sequence[bytes]) -> list[float]:
    """Read words that must be finite numbers: metres, radians, seconds.

    Raises:
        BrokenLineError: a word is not a finite number.
    """
    try:
        values = list(map(float, words))
    except ValueError:
        fault = DECIMAL_COMMA if b"," in b"".join(words) else NO_NUMBER
        raise BrokenLineError(fault) from None
    if not math.isfinite(sum(values)) or has_grouped_digits(words):
        raise BrokenLineError(NO_NUMBER)
    return values


def exact_ns(seconds: bytes, value: float) -> int | None:
    """A time in nanoseconds, exact to the last digit; None if no calendar has it.

    Args:
        seconds: the word.
        value: the same as a number, in seconds; finite.

    Raises:
        BrokenLineError: no decimal number has its exponent, as that of 0e99999999999999999999.
    """
    if not _FIRST_SECOND <= value < _LAST_SECOND:
        return None
    try:
        return round(Decimal(seconds.decode()).scaleb(9))
    except InvalidOperation:
        raise BrokenLineError(NO_NUMBER) from None


def calendar_ns(time_ns: int) -> int | None:
    """The same time, or None if a protobuf Timestamp cannot hold it."""
    return time_ns if _FIRST_SECOND <= time_ns // 1_000_000_000 <= _LAST_SECOND else None
