"""The CARMEN log format: one message a line, words separated by blanks, SI units.

    ODOM x y theta tv rv accel time host logger_time
    PARAM name value time host logger_time

Laser messages stand in `carmen_lines`, their angles in `carmen_angles`. A file may have several
lasers, and one laser in several messages; the log has one of them, that in front and with poses if
there is one. Every other line is counted and passed over. Source: the CARMEN toolkit's logger, as
the Robotics Data Set Repository (Radish) keeps its logs.

Distances of 50 m and more mean "no return", and so do those that reach the scanner's own largest
range where the message says it: SICK scanners report 50, 51.05 to 51.16 or 81.8 to 81.9 m for it,
and indoors nothing is as far away. (The largest distance of the file would be a better bound, but
the file is read only once.) Distances that are not positive are unknown.

Where a present message has both the laser's pose and the robot's, the pose is the robot's and the
scan says how the laser sits on it. An old message has the pose of the laser in their place, as a
mapper corrected it, and the odometry. Mappers write the corrected pose into the odometry's fields
too, and an ODOM line at time 0 behind it. So the odometry of a scan is its own only where it
differs from its pose; elsewhere it is the newest ODOM line with a time since the scan before, if
there is one.
"""

import re
from collections import Counter

import numpy as np
import numpy.typing as npt

from reflexarc_logs.importing.carmen_angles import LaserParams, SweepAngles, fan_of_words
from reflexarc_logs.importing.carmen_lines import LaserLine, LaserSettings, kind_of, rank
from reflexarc_logs.importing.carmen_poses import places_of
from reflexarc_logs.importing.number_words import read_numbers
from reflexarc_logs.importing.scan_line import (
    NO_RETURN,
    UNKNOWN,
    BrokenLineError,
    Sweep,
    TimedPose,
    exact_ns,
    finite,
)

NO_RETURN_M = 50.0
MOST_KEYWORDS = 100
"""As many kinds of messages are counted by name: no hostile file fills the memory."""

_ODOMETRY = b"ODOM"
_KEYWORD = re.compile(rb"[A-Z][A-Z0-9_]{1,31}(?=\s|$)")
"""What the logger writes: IMU, NMEAGGA, SONAR, MARKER, and what others added."""
_OTHERS = "other messages"
_FEW = 0.5
"""A laser with less than this share of the scans of another one is not the file's."""


class Carmen:
    """Reads the lines of one CARMEN log, in order."""

    expects = "lines that begin with FLASER, RLASER, ROBOTLASER1 or RAWLASER1"
    no_distance = "not positive"
    blind_beams = 0

    def __init__(self) -> None:
        self._passed_over: Counter[str] = Counter()
        self._odometry_lines = 0
        self._newest_odometry = b""
        self._laser = b""
        self._params = LaserParams()

    def foresee(self, lines: list[bytes]) -> None:
        """See `LineReader.foresee`: which of several lasers is read."""
        counts = Counter(filter(None, (_whole_scan(line) for line in lines)))
        enough = max(counts.values(), default=0) * _FEW
        lasers = [keyword for keyword, count in counts.items() if count >= enough]
        self._laser = min(lasers, key=rank, default=b"")

    def sweep(self, line: bytes) -> Sweep | None:
        """See `LineReader.sweep`."""
        if line.startswith(_ODOMETRY) and line[4:5].isspace():  # the most frequent line by far
            self._odometry_lines += 1
            if not _is_a_copy(line):
                self._newest_odometry = line
            return None
        if b"LASER" in line[:10]:
            words = line.split()
            if words and self._is_read(words[0]):
                return self._scan(words)
        self._pass_over(line)
        return None

    def passed_over(self) -> dict[str, int]:
        """See `LineReader.passed_over`."""
        odometry = {"ODOM": self._odometry_lines} if self._odometry_lines else {}
        return odometry | dict(self._passed_over)

    def notes(self) -> tuple[str, ...]:
        """See `LineReader.notes`."""
        if self._laser in (b"", b"FLASER", b"ROBOTLASER1", b"RAWLASER1"):
            return ()
        return (f"the scans are those of {self._laser.decode()}: ahead is where that laser looks",)

    def _is_read(self, keyword: bytes) -> bool:
        if not self._laser and kind_of(keyword) is not None:
            self._laser = keyword
        return keyword == self._laser

    def _scan(self, words: list[bytes]) -> Sweep:
        take_apart = kind_of(words[0])
        assert take_apart is not None, words[0]
        line = take_apart(words)
        time_ns = None if line.time is None else exact_ns(line.time, *finite([line.time]))
        fan, farthest_m = self._how_it_measured(words[0], line)
        places = places_of(line, time_ns)
        odometry = self._odometry() if places.odometry is None else places.odometry
        self._newest_odometry = b""
        numbers, unreadable = read_numbers(line.ranges)
        return Sweep(
            time_ns,
            fan.start_rad,
            fan.end_rad,
            _metres(numbers, farthest_m),
            int(np.count_nonzero(unreadable)),
            places.pose,
            odometry,
            places.mount,
        )

    def _how_it_measured(self, keyword: bytes, line: LaserLine) -> tuple[SweepAngles, float]:
        """The bearings of a line's beams, and the distance that means "no return"."""
        beams, settings = len(line.ranges), line.settings
        if settings is None:
            laser = b"rear" if keyword == b"RLASER" else b"front"
            return self._params.fan(beams, laser), NO_RETURN_M
        fan = fan_of_words(beams, settings.start, settings.fov, settings.resolution)
        return fan, _farthest_m(settings)

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
        if line.startswith(b"PARAM"):
            self._params.note(line)
        found = _KEYWORD.match(line)
        if found is not None or line.startswith(b"#"):
            word = found[0].decode() if found is not None else "#"
            known = word in self._passed_over or len(self._passed_over) < MOST_KEYWORDS
            self._passed_over[word if known else _OTHERS] += 1
        elif line.strip():
            raise BrokenLineError("unknown keyword")


def _whole_scan(line: bytes) -> bytes | None:
    """The keyword of a line that is a scan and not broken; None for any other."""
    if b"LASER" not in line[:10]:
        return None
    words = line.split()
    take_apart = kind_of(words[0])
    try:
        return None if take_apart is None or take_apart(words) is None else words[0]
    except BrokenLineError:
        return None


def _is_a_copy(odometry: bytes) -> bool:
    """Whether a mapper put its own pose here: at time 0, which no clock says."""
    if odometry.rsplit(None, 1)[-1].strip(b"0."):
        return False
    return not odometry.split()[-3].strip(b"0.")


def _farthest_m(settings: LaserSettings) -> float:
    (farthest_m,) = finite([settings.farthest])
    return min(farthest_m, NO_RETURN_M) if farthest_m > 0.0 else NO_RETURN_M


def _metres(numbers: npt.NDArray[np.float64], farthest_m: float) -> npt.NDArray[np.float64]:
    known = np.where(numbers > 0.0, numbers, UNKNOWN)
    return np.where(numbers >= farthest_m, NO_RETURN, known)
