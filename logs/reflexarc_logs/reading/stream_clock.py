"""When something was, on the wall clock, by a stamp that a message holds.

A log's `log_time` is the wall clock. The stamps inside messages are on their sender's clock, for
replay needs them as they were: of a body on the same machine that is the monotonic clock, and the
log's metadata say how far the wall clock is ahead of it; of a robot that speaks ROS 2 it is the
robot's wall clock; of an imported file it may be any. One rule holds for a whole stream.
"""

NEAR_NS = 60_000_000_000
"""How far a stamp may be from its arrival on one and the same clock."""


class StreamClock:
    """Reads the stamps of one stream; its first message tells by which clock they are.

    Args:
        wall_offset_ns: wall clock minus the recorder's monotonic clock.
    """

    def __init__(self, wall_offset_ns: int) -> None:
        self._wall_offset_ns = wall_offset_ns
        self._is_known = False
        self._shift_ns: int | None = None

    def wall_ns(self, stamp_ns: int, log_ns: int) -> int:
        """A stamp on the wall clock; of a clock that nobody knows, the arrival.

        Args:
            stamp_ns: on the sender's clock.
            log_ns: when the message arrived, by the wall clock.
        """
        if not self._is_known:
            self._is_known = True
            shifts = 0, self._wall_offset_ns
            near = (s for s in shifts if abs(log_ns - stamp_ns - s) <= NEAR_NS)
            self._shift_ns = next(near, None)
        return log_ns if self._shift_ns is None else stamp_ns + self._shift_ns
