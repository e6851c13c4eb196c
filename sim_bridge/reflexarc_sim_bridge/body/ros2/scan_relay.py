"""The robot's scans, passed on to our bus as they come."""

import logging
from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.messages import (
    STANDARD,
    RosScanner,
    UnusableMessageError,
    decode_scan,
    encode_scan,
)

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

MOST_REASONS = 16
"""So many different reasons are counted apart."""

_LOG = logging.getLogger(__name__)


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
        scanner: what is known of the robot's scanner.
    """

    def __init__(self, publisher: "Publisher", scanner: RosScanner = STANDARD) -> None:
        self._publisher, self._scanner = publisher, scanner
        self.scans = 0
        self.refused: Counter[str] = Counter()

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            payload = encode_scan(decode_scan(message.payload, self._scanner))
        except UnusableMessageError as error:
            self._refuse(str(error))
            return
        self.scans += 1
        self._publisher.put(payload, message.received_ns)

    def _refuse(self, reason: str) -> None:
        if reason not in self.refused and len(self.refused) >= MOST_REASONS:
            reason = "for other reasons"  # their numbers differ, and memory is bounded
        self.refused[reason] += 1
        if self.refused[reason] == 1:
            _LOG.warning("a scan of the robot is refused: %s (said once)", reason)
