"""Twists as they go to the robot: encoded, stamped with the wall clock, counted."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Twist
from reflexarc_sim_bridge.body.ros2.messages import encode_twist, encode_twist_stamped

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

COMMAND_FRAME = "base_link"
"""Frame of a stamped command: the robot's own (REP 105)."""
CDR = "application/cdr"
"""Zenoh's encoding of what ROS 2 says."""

_SPEEDS_BYTES = 6 * 8


def moves(payload: bytes) -> bool:
    """Whether a twist, stamped or not, is anything but standstill.

    Both messages end with six doubles, and a double is zero when all its bytes are.
    """
    return any(payload[-_SPEEDS_BYTES:])


class TwistPublisher:
    """Sends motions as twists.

    Args:
        publisher: on the robot's wire.
        stamped: whether the robot takes stamped commands.
        wall_offset: what to add to `now_ns` to get the wall clock, by which ROS stamps.
    """

    def __init__(
        self, publisher: "Publisher", stamped: bool, wall_offset: Callable[[], int]
    ) -> None:
        self._publisher = publisher
        self._stamped = stamped
        self._wall_offset = wall_offset
        self.count = 0
        # The first conversion reads the definitions of all messages, for 0.1 s: not when it counts.
        self._encode(STANDSTILL, 0)

    def send(self, motion: Twist, now_ns: int) -> None:
        """Send a motion; never blocks."""
        wall_ns = now_ns + self._wall_offset()
        self._publisher.put(self._encode(motion, wall_ns), wall_ns)
        self.count += 1

    def _encode(self, motion: Twist, wall_ns: int) -> bytes:
        if self._stamped:
            return encode_twist_stamped(motion, wall_ns, COMMAND_FRAME)
        return encode_twist(motion)
