"""Twists as they go to the robot: encoded, stamped, counted."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Twist
from reflexarc_sim_bridge.body.ros2.messages import encode_twist, encode_twist_stamped
from reflexarc_sim_bridge.body.ros2.stamps import NO_STAMP_NS, Stamper

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
        stamper: what the commands are stamped with; None for a robot that takes unstamped ones.
        wall_offset: what to add to `now_ns` to get the wall clock, for the attachment.
    """

    def __init__(
        self, publisher: "Publisher", stamper: Stamper | None, wall_offset: Callable[[], int]
    ) -> None:
        self._publisher = publisher
        self._stamper = stamper
        self._wall_offset = wall_offset
        self.count = 0
        # The first conversion reads the definitions of all messages, for 0.1 s: not when it counts.
        encode_twist(STANDSTILL)
        encode_twist_stamped(STANDSTILL, NO_STAMP_NS, COMMAND_FRAME)

    def send(self, motion: Twist, now_ns: int, source_ns: int | None = None) -> None:
        """Send a motion; never blocks.

        Args:
            motion: what the robot shall do.
            now_ns: on our clock.
            source_ns: when the scan arrived that it came from; None: it is a standstill.
        """
        payload = self._encode(motion, now_ns, source_ns)
        self._publisher.put(payload, now_ns + self._wall_offset())
        self.count += 1

    def _encode(self, motion: Twist, now_ns: int, source_ns: int | None) -> bytes:
        if self._stamper is None:
            return encode_twist(motion)
        stamp_ns = self._stamper.stamp_ns(now_ns, source_ns)
        return encode_twist_stamped(motion, stamp_ns, COMMAND_FRAME)
