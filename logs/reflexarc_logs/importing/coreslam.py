"""The log format of CoreSLAM (tinySLAM): one scan of a Hokuyo URG-04LX a line, numbers and blanks.

Word 0 is the time in microseconds, words 2 and 3 the counts of the two wheel encoders, words 24 to
705 are 682 ranges in millimetres from the right (−120°) to the left (+120°); one more number may
stand at the end. Some programs write all of them with decimals. Source: Steux and El Hamzaoui,
"tinySLAM", and BreezySLAM's copy of its data.

0 means "no return". 1 to 19 are error codes of the sensor, and negative numbers are not defined:
both are unknown. The first and the last 70 beams see the robot itself or nothing, whatever their
number (the detection margin of tinySLAM's own example), so they are unknown too: ±95° remain. The
file does not say how large the wheels are, so their counts do not become odometry.
"""

import math
from decimal import Decimal, InvalidOperation

import numpy as np
import numpy.typing as npt

from reflexarc_logs.importing.number_words import read_numbers
from reflexarc_logs.importing.scan_line import (
    NO_NUMBER,
    NO_RETURN,
    UNKNOWN,
    BrokenLineError,
    Sweep,
    calendar_ns,
    finite,
)

BEAMS = 682
BLIND_BEAMS = 70
"""On each side."""
FIRST_DISTANCE_MM = 20
START_RAD, END_RAD = -math.radians(120.0), math.radians(120.0)

_FIRST_RANGE = 24
_WORDS = _FIRST_RANGE + BEAMS
_SEEING = slice(_FIRST_RANGE + BLIND_BEAMS, _WORDS - BLIND_BEAMS)
"""Words of the beams between the blind ones."""
_BLIND = np.full(BLIND_BEAMS, UNKNOWN)


class CoreSlam:
    """Reads the lines of one CoreSLAM log, in order."""

    expects = f"lines of {_WORDS} or {_WORDS + 1} numbers"
    no_distance = "error code"
    blind_beams = 2 * BLIND_BEAMS

    def __init__(self) -> None:
        self._wheel_counts = 0

    def foresee(self, lines: list[bytes]) -> None:
        """See `LineReader.foresee`; all lines are of one kind."""

    def sweep(self, line: bytes) -> Sweep | None:
        """See `LineReader.sweep`."""
        words = line.split()
        if not words:
            return None
        if not _WORDS <= len(words) <= _WORDS + 1:
            raise BrokenLineError("wrong count of numbers")
        if len(words) == _WORDS and not line.endswith(b"\n"):
            raise BrokenLineError("cut off")  # its last number may have lost digits
        time_ns = _time_ns(words[0])
        self._wheel_counts += 1
        numbers, unreadable = read_numbers(words[_SEEING])
        ranges_m = np.concatenate((_BLIND, _metres(numbers), _BLIND), dtype="<f8")
        return Sweep(time_ns, START_RAD, END_RAD, ranges_m, int(np.count_nonzero(unreadable)))

    def passed_over(self) -> dict[str, int]:
        """See `LineReader.passed_over`."""
        return {}

    def notes(self) -> tuple[str, ...]:
        """See `LineReader.notes`."""
        return (
            f"{self._wheel_counts} pairs of wheel encoder counts were read and not written: the "
            "file does not say how far a count is",
        )


def _time_ns(word: bytes) -> int | None:
    """A time in microseconds, exact to its last digit; None if no calendar has it."""
    (microseconds,) = finite([word])
    if calendar_ns(round(microseconds) * 1000) is None:
        return None
    try:
        return calendar_ns(round(Decimal(word.decode()) * 1000))
    except InvalidOperation:
        raise BrokenLineError(NO_NUMBER) from None


def _metres(numbers: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    measured = (numbers >= FIRST_DISTANCE_MM) & np.isfinite(numbers)
    return np.where(numbers == 0.0, NO_RETURN, np.where(measured, numbers / 1000.0, UNKNOWN))
