"""The time in the header of a twist that is sent to a robot.

ros2_controllers, `diff_drive_controller.cpp` (also mecanum and steering): a twist whose stamp is
zero is taken as of now; one that is as old as `cmd_vel_timeout` when it comes is ignored; and what
it said last holds until its stamp is older than that. All this is asked of the robot's clock, so
our wall clock must not be in it: 3 s ahead, it lets a robot drive on for 3 s after the last word;
1 s behind, the robot never moves. The stamp of a scan is the robot's own.
"""

import threading
from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum

NO_STAMP_NS = 0
"""The receiver takes it for now."""
REMEMBERED_SCANS = 512
"""Ten seconds at 50 Hz: far longer than any command is valid."""


class StampRule(StrEnum):
    """What a twist is stamped with: the values of `--stamp`."""

    SCAN = "scan"
    """What moves the robot bears the stamp of its scan; a standstill, which is never too old, none.
    """
    WALL = "wall"
    """This machine's wall clock at the moment of sending."""
    ZERO = "zero"
    """Nothing, which means now."""


class ScanStamps:
    """Which stamp a scan had that arrived at a time. Written by a thread of the bus."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._arrived_ns: deque[int] = deque(maxlen=REMEMBERED_SCANS)
        self._stamp_ns: deque[int] = deque(maxlen=REMEMBERED_SCANS)

    def note(self, arrived_ns: int, stamp_ns: int) -> None:
        """Remember a scan; they come in the order of their arrival."""
        with self._lock:
            self._arrived_ns.append(arrived_ns)
            self._stamp_ns.append(stamp_ns)

    def at(self, time_ns: int) -> int:
        """The stamp of the newest scan that had arrived by then; no stamp if none had."""
        with self._lock:
            place = bisect_right(self._arrived_ns, time_ns) - 1
            return self._stamp_ns[place] if place >= 0 else NO_STAMP_NS


@dataclass(frozen=True)
class Stamper:
    """Says what a twist is stamped with."""

    rule: StampRule
    wall_offset: Callable[[], int]
    """What to add to our clock to get the wall clock."""
    scans: ScanStamps = field(default_factory=ScanStamps)

    def stamp_ns(self, now_ns: int, source_ns: int | None) -> int:
        """The stamp of a twist.

        Args:
            now_ns: when it is sent, on our clock.
            source_ns: when the scan arrived that it came from; None: it is a standstill.
        """
        if self.rule is StampRule.WALL:
            return now_ns + self.wall_offset()
        if self.rule is StampRule.ZERO or source_ns is None:
            return NO_STAMP_NS
        return self.scans.at(source_ns)
