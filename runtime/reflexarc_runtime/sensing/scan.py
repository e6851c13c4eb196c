"""One sweep of a range sensor, as the robot's own frame sees it."""

import math
from dataclasses import dataclass

from reflexarc_runtime.arrays import Ranges

MIN_STEP_RAD = 1e-9
"""Smallest angle between beams that is accepted; below it, the index of a beam may overflow."""
MOST_BEAMS = 1 << 14
"""Finer than any scanner that is sold; reading more would take a loop's time."""
IGNORED_M = -(2.0**-10)
"""In place of the range of a beam on which the scanner sees its own robot; no driver writes it."""
MOST_TURNS = 1.1
"""Some scanners measure a little more than a full turn; more than that are degrees, or nonsense."""
FARTHEST_RAD = 6.0 * math.pi
"""No bearing is more turns away from ahead: degrees, or nonsense."""


@dataclass(frozen=True)
class Scan:
    """One sweep of a range sensor. Beams go counter-clockwise from `start_rad` to `end_rad`.

    A range of +inf means that nothing was met, −inf that something is too near to be measured;
    NaN, zero and other negative ones are no measurement: unknown.
    """

    start_rad: float
    end_rad: float
    ranges_m: Ranges
    x_m: float = 0.0
    """Where the beams begin, ahead of the point about which the robot turns."""
    y_m: float = 0.0
    """And to the left of it."""

    @property
    def step_rad(self) -> float:
        """Angle from one beam to the next."""
        return (self.end_rad - self.start_rad) / (len(self.ranges_m) - 1)

    @property
    def is_centred(self) -> bool:
        """Whether the beams begin at the point about which the robot turns."""
        return math.hypot(self.x_m, self.y_m) < 1e-6


class UnusableScanError(ValueError):
    """A scan from which no retina can be made; its message says why."""


def check_sweep(scan: Scan) -> None:
    """Refuse a sweep whose angles cannot be meant.

    Raises:
        UnusableScanError: fewer than two beams, in the wrong order, or over more than a turn.
    """
    count = len(scan.ranges_m)
    if count < 2 or not MIN_STEP_RAD <= scan.step_rad <= math.pi:
        raise UnusableScanError(f"{count} beams from {scan.start_rad} to {scan.end_rad} rad")
    check_turns(scan)


def check_turns(scan: Scan) -> None:
    """Refuse a sweep over more than a turn, or many turns away.

    Raises:
        UnusableScanError: it is one.
    """
    turns = (scan.end_rad - scan.start_rad) / (2.0 * math.pi)
    if turns > MOST_TURNS:
        raise UnusableScanError(
            f"beams from {scan.start_rad:.3f} to {scan.end_rad:.3f} rad, which is {turns:.1f} "
            "turns; if the driver counts in degrees: --angles degrees"
        )
    if max(abs(scan.start_rad), abs(scan.end_rad)) > FARTHEST_RAD:
        raise UnusableScanError(
            f"beams from {scan.start_rad:.3f} to {scan.end_rad:.3f} rad, many turns from ahead; "
            "if the driver counts in degrees: --angles degrees"
        )
