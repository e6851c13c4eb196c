"""The CARMEN log format: one message a line, words separated by blanks, SI units.

    FLASER n r_1 … r_n x y theta odom_x odom_y odom_theta time host logger_time
    ODOM x y theta tv rv accel time host logger_time

n ranges, evenly spread from −90° (right) to +90° (left); then the pose that the mapper corrected.
Every other line is counted and passed over. Source: the CARMEN toolkit's logger, as the Robotics
Data Set Repository (Radish) keeps its logs.

Distances of 50 m and more mean "no return": SICK scanners report 50, 51.05 to 51.16 or 81.8 to
81.9 m for it, and indoors nothing is as far away. (The largest distance of the file would be a
better bound, but the file is read only once.) Distances that are not positive are unknown.

Mappers write the corrected pose into the odometry's fields too, and an ODOM line at time 0 behind
it. So the odometry of a scan is its own only where it differs from its pose; elsewhere it is the
newest ODOM line with a time since the scan before, if there is one.
"""

import math
from collections import Counter

import numpy as np
import numpy.typing as npt

from reflexarc_logs.importing.number_words import read_numbers
from reflexarc_logs.importing.scan_line import (
    MAX_BEAMS,
    NO_RETURN,
    UNKNOWN,
    BrokenLineError,
    Sweep,
    TimedPose,
    exact_ns,
    finite,
)

NO_RETURN_M = 50.0
START_RAD, END_RAD = -math.pi / 2, math.pi / 2

_SCAN, _ODOMETRY = b"FLASER", b"ODOM"
_WORDS_BEFORE, _WORDS_BEHIND = 2, 9
"""Words of a FLASER line around its ranges: keyword, n; six of poses, three of times."""
_KEYWORDS = frozenset(
    b"PARAM SYNC NEFF RLASER TRUEPOS RAWLASER1 RAWLASER2 RAWLASER3 RAWLASER4 ROBOTLASER0 "
    b"ROBOTLASER1 LASER3 LASER4".split()
)
"""What the logs' own headers name, and what GMapping adds."""


class Carmen:
    """Reads the lines of one CARMEN log, in order."""

    expects = "lines that begin with FLASER"
    no_distance = "not positive"
    blind_beams = 0

    def __init__(self) -> None:
        self._passed_over: Counter[str] = Counter()
        self._odometry_lines = 0
        self._newest_odometry = b""

    def sweep(self, line: bytes) -> Sweep | None:
        """See `LineReader.sweep`."""
        if line.startswith(_ODOMETRY):  # the most frequent line by far
            self._odometry_lines += 1
            if not line.endswith(b" 0\n"):  # time 0: what a mapper repeats of its own pose
                self._newest_odometry = line
            return None
        if line.startswith(_SCAN):
            words = line.split()
            if words[0] == _SCAN:
                return self._scan(words)
        self._pass_over(line)
        return None

    def passed_over(self) -> dict[str, int]:
        """See `LineReader.passed_over`."""
        odometry = {"ODOM": self._odometry_lines} if self._odometry_lines else {}
        return odometry | dict(self._passed_over)

    def notes(self) -> tuple[str, ...]:
        """See `LineReader.notes`."""
        return ()

    def _scan(self, words: list[bytes]) -> Sweep:
        ranges = words[_WORDS_BEFORE:-_WORDS_BEHIND]
        _check_count(words, len(ranges))
        *places, time = words[-_WORDS_BEHIND:-2]
        x_m, y_m, heading_rad, *own, seconds = finite([*places, time])
        time_ns = exact_ns(time, seconds)
        pose = TimedPose(x_m, y_m, heading_rad, time_ns)
        repeated = places[:3] == places[3:]
        odometry = self._odometry() if repeated else TimedPose(own[0], own[1], own[2], time_ns)
        self._newest_odometry = b""
        numbers, unreadable = read_numbers(ranges, float)
        ranges_m, count = _metres(numbers), int(np.count_nonzero(unreadable))
        return Sweep(time_ns, START_RAD, END_RAD, ranges_m, count, pose, odometry)

    def _odometry(self) -> TimedPose | None:
        """What the newest ODOM line says, if there was one."""
        words = self._newest_odometry.split()
        if not words:
            return None
        try:
            _, *place, _, _, _, time, _, _ = words
            x_m, y_m, heading_rad, seconds = finite([*place, time])
            return TimedPose(x_m, y_m, heading_rad, exact_ns(time, seconds))
        except ValueError:
            self._passed_over["ODOM, broken"] += 1
            return None

    def _pass_over(self, line: bytes) -> None:
        """Count a line that carries no scan.

        Raises:
            BrokenLineError: no log of this format has such lines.
        """
        word = b"".join(line.split(None, 1)[:1])
        if word.startswith(b"#"):
            self._passed_over["#"] += 1
        elif word in _KEYWORDS:
            self._passed_over[word.decode()] += 1
        elif word:
            raise BrokenLineError("unknown keyword")


def _check_count(words: list[bytes], beams: int) -> None:
    """Check that a FLASER line has as many ranges as its second word says.

    Raises:
        BrokenLineError: it has more or fewer.
    """
    if not 2 <= beams <= MAX_BEAMS or words[1] != b"%d" % beams:
        raise BrokenLineError("wrong count of ranges")


def _metres(numbers: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    known = np.where(numbers > 0.0, numbers, UNKNOWN)
    return np.where(numbers >= NO_RETURN_M, NO_RETURN, known)
