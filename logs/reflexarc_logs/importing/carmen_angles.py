"""Which way the beams of a CARMEN scan look.

The present messages say it themselves. The old ones (FLASER, RLASER) give ranges only, and the
number of ranges tells the mode of the SICK scanner that measured them. In the modes of 180, 360 and
400 ranges the last beam was left out. Source: `carmen_laser_guess_fov` and
`carmen_laser_guess_angle_increment` in the toolkit's readlog.c. (It begins the mode of 100° at
−90°, as all others; the scanner itself looks straight ahead.)

A PARAM line for the field of view stands above the guess. Its unit is radians or degrees, by who
wrote it: more than a full turn in radians is degrees. The resolution is always in degrees.
"""

import math
import re
from typing import NamedTuple

from reflexarc_logs.importing.scan_line import BrokenLineError, finite

MOST_RAD = 2.2 * math.pi
"""Some scanners measure a little more than a full turn; no scanner sees more."""

_SICK_MODES_DEG = {
    181: (180.0, 1.0),
    180: (180.0, 1.0),
    361: (180.0, 0.5),
    360: (180.0, 0.5),
    401: (100.0, 0.25),
    400: (100.0, 0.25),
}
"""Field of view and resolution by the number of ranges."""
_OTHERS_DEG, _TURN_DEG = 180.0, 360.0
_TELLING = re.compile(rb"PARAM\s+\S*(front|rear)_laser_(fov|resolution)\s+(\S+)")


class SweepAngles(NamedTuple):
    """Bearings of the first beam, on the right, and of the last one."""

    start_rad: float
    end_rad: float


class LaserParams:
    """What the PARAM lines of a file have said so far of the lasers of the old messages."""

    def __init__(self) -> None:
        self._values: dict[tuple[bytes, bytes], float] = {}

    def note(self, line: bytes) -> None:
        """Remember a line if it tells a laser's field of view or resolution."""
        found = _TELLING.match(line)
        if found is None:
            return
        laser, field, number = found.groups()
        try:
            (value,) = finite([number])
        except ValueError:
            return
        if value > 0.0:
            self._values[laser, field] = value

    def fan(self, beams: int, laser: bytes) -> SweepAngles:
        """The bearings of an old message's beams.

        Args:
            beams: how many, at least two.
            laser: `front` or `rear`.

        Raises:
            BrokenLineError: more than a full turn.
        """
        fov, step_deg = (self._values.get((laser, word)) for word in (b"fov", b"resolution"))
        if fov is not None and fov <= MOST_RAD:
            fov = math.degrees(fov)
        return _checked(_old_fan(beams, fov, step_deg))


def fan_of_words(beams: int, start: bytes, fov: bytes, step: bytes) -> SweepAngles:
    """The bearings of a present message's beams, by its own three numbers in radians.

    The resolution decides, as in the toolkit; where it agrees with the field of view, that is the
    finer number.

    Raises:
        BrokenLineError: a word is no number; the angles grow clockwise or over more than a turn.
    """
    start_rad, fov_rad, step_rad = finite([start, fov, step])
    span_rad = (beams - 1) * step_rad
    if step_rad == 0.0 or abs(span_rad - fov_rad) < 0.5 * step_rad:
        span_rad = fov_rad
    elif abs(span_rad + step_rad - fov_rad) < 0.5 * step_rad:
        span_rad = fov_rad * (beams - 1) / beams  # the last beam was left out
    return _checked(SweepAngles(start_rad, start_rad + span_rad))


def _old_fan(beams: int, fov_deg: float | None, step_deg: float | None) -> SweepAngles:
    """Begin at the right edge of the field of view and go on by steps that fit it."""
    mode_deg, mode_step_deg = _SICK_MODES_DEG.get(beams, (math.inf, 0.0))
    if math.isfinite(mode_deg) and (fov_deg is None or abs(fov_deg - mode_deg) <= mode_step_deg):
        fov_deg, step = mode_deg, mode_step_deg
    elif fov_deg is not None:
        steps = beams - 1 if step_deg is None else round(fov_deg / step_deg)
        step = fov_deg / (beams if steps == beams else beams - 1)  # the last beam was left out
    elif step_deg is not None and (beams - 1) * step_deg <= _TURN_DEG:
        fov_deg, step = (beams - 1) * step_deg, step_deg
    else:
        fov_deg, step = _OTHERS_DEG, _OTHERS_DEG / (beams - 1)
    right_deg = -fov_deg / 2
    return SweepAngles(math.radians(right_deg), math.radians(right_deg + (beams - 1) * step))


def _checked(fan: SweepAngles) -> SweepAngles:
    if not 0.0 < fan.end_rad - fan.start_rad <= MOST_RAD or abs(fan.start_rad) > MOST_RAD:
        raise BrokenLineError("angles of no scanner")
    return fan
