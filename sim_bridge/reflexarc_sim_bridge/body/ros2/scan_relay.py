"""The robot's scans, passed on to our bus as they come, with the time at which they were taken.

That time is on this machine's clock: the arrival, minus how far behind the driver's best the scan
came, by the stamp in its header. So runtime and gate both see a queue between driver and bridge.
"""

import logging
from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.backlog import NO_LAG
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

SILENCE_NS = 1_000_000_000
"""A driver that was silent for longer may have begun anew, with another clock."""

_LOG = logging.getLogger(__name__)


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
        scanner: what is known of the robot's scanner.
        heeds_stamps: whether the stamps in the headers count; not those of a simulator whose time
            runs slower than ours.
    """

    def __init__(
        self,
        publisher: "Publisher",
        scanner: RosScanner = STANDARD,
        *,
        heeds_stamps: bool = True,
    ) -> None:
        self._publisher, self._scanner = publisher, scanner
        self._heeds_stamps = heeds_stamps
        self._backlog = NO_LAG
        self.scans = 0
        self.refused: Counter[str] = Counter()

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            scan = decode_scan(message.payload, self._scanner)
        except UnusableMessageError as error:
            self._refuse(str(error))
            return
        self.scans += 1
        taken_ns = self._taken_ns(scan.stamp_ns, message.received_ns)
        self._publisher.put(encode_scan(scan), taken_ns)

    def _taken_ns(self, stamp_ns: int, received_ns: int) -> int:
        """When a scan would have come without a queue."""
        if not self._heeds_stamps:
            return received_ns
        self._backlog = self._backlog.after(max(0, stamp_ns), received_ns, SILENCE_NS)
        return max(0, received_ns - self._backlog.behind_ns)

    def _refuse(self, reason: str) -> None:
        if reason not in self.refused and len(self.refused) >= MOST_REASONS:
            reason = "for other reasons"  # their numbers differ, and memory is bounded
        self.refused[reason] += 1
        if self.refused[reason] == 1:
            _LOG.warning("a scan of the robot is refused: %s (said once)", reason)
