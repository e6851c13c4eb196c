"""The laser messages of a CARMEN log, taken apart into words.

    FLASER n r_1 … r_n x y theta odom_x odom_y odom_theta [time host logger_time]
    RAWLASER1 type start fov resolution max accuracy mode n r_1 … r_n m e_1 … e_m [time host logged]
    ROBOTLASER1 type … m e_1 … e_m laser_x laser_y laser_theta robot_x robot_y robot_theta
                tv rv front_distance side_distance turn_axis [time host logger_time]

FLASER is the front laser, RLASER the rear one; the digit behind RAWLASER and ROBOTLASER counts the
lasers of a robot. m is the number of remission values, which some writers leave out. Some mappers
leave out the times. Source: writelog.c and readlog.c of the CARMEN toolkit.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

from reflexarc_logs.importing.scan_line import MAX_BEAMS, BrokenLineError

_POSES, _MOTION, _TIMES = 6, 5, 3
"""Words of two planar poses; of speeds and distances; of two times and a host's name."""
_SETTINGS = 7
"""Words of a present message before the number of ranges."""
_MOST_DIGITS = 6


class LaserSettings(NamedTuple):
    """How a scanner was set up, by the present messages."""

    start: bytes
    fov: bytes
    resolution: bytes
    farthest: bytes


class LaserLine(NamedTuple):
    """The words of one scan that matter."""

    ranges: Sequence[bytes]
    places: Sequence[bytes]
    """Six words of the laser's pose and the robot's; none if the message has no poses."""
    time: bytes | None
    settings: LaserSettings | None = None
    """None for the old messages."""


TakeApart: TypeAlias = Callable[[list[bytes]], LaserLine]


def kind_of(keyword: bytes) -> TakeApart | None:
    """How to take apart the lines of a keyword; None if it is not that of a laser that is read."""
    if keyword in (b"FLASER", b"RLASER"):
        return _old
    if keyword[:-1] == b"RAWLASER" and keyword[-1:].isdigit():
        return _raw
    if keyword[:-1] == b"ROBOTLASER" and keyword[-1:].isdigit():
        return _robot
    return None


def rank(keyword: bytes) -> tuple[bool, int, bytes]:
    """The least one is the best of several lasers: in front, and with poses."""
    front = keyword in (b"FLASER", b"RAWLASER1", b"ROBOTLASER1")
    order = (_robot, _old, _raw)
    kind = kind_of(keyword)
    return (not front, order.index(kind) if kind in order else len(order), keyword)


def _old(words: list[bytes]) -> LaserLine:
    ranges, rest = _counted(words[1:])
    _check_beams(len(ranges))
    return LaserLine(ranges, rest[:_POSES], _time(rest, _POSES))


def _raw(words: list[bytes]) -> LaserLine:
    settings, ranges, rest = _present(words, 0)
    return LaserLine(ranges, (), _time(rest, 0), settings)


def _robot(words: list[bytes]) -> LaserLine:
    settings, ranges, rest = _present(words, _POSES + _MOTION)
    return LaserLine(ranges, rest[:_POSES], _time(rest, _POSES + _MOTION), settings)


def _present(words: list[bytes], behind: int) -> tuple[LaserSettings, list[bytes], list[bytes]]:
    """LaserSettings, ranges, and what follows the remission values of a present message."""
    _, _, start, fov, resolution, farthest, *_ = [*words, b"", b"", b"", b"", b"", b""]
    ranges, rest = _counted(words[1 + _SETTINGS :])
    _check_beams(len(ranges))
    if len(rest) not in (behind, behind + _TIMES):
        _, rest = _counted(rest)
    return LaserSettings(start, fov, resolution, farthest), ranges, rest


def _counted(words: list[bytes]) -> tuple[list[bytes], list[bytes]]:
    """As many words as the first one says, and those behind them.

    Raises:
        BrokenLineError: the first word is no number, or there are fewer.
    """
    number = words[0] if words else b""
    if not number.isdigit() or len(number) > _MOST_DIGITS or int(number) >= len(words):
        raise BrokenLineError("wrong count of ranges")
    end = 1 + int(number)
    return words[1:end], words[end:]


def _check_beams(beams: int) -> None:
    if not 2 <= beams <= MAX_BEAMS:
        raise BrokenLineError("wrong count of ranges")


def _time(rest: list[bytes], before: int) -> bytes | None:
    """The scanner's time; None if the line ends before the times.

    Raises:
        BrokenLineError: there are other words than it may have.
    """
    if len(rest) == before:
        return None
    if len(rest) != before + _TIMES:
        raise BrokenLineError("wrong count of ranges")
    return rest[before]
