"""The robot's scans, passed on to our bus as they come."""

from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.cdr import UnusableMessageError
from reflexarc_sim_bridge.body.ros2.messages import STANDARD, RosScanner, decode_scan, encode_scan
from reflexarc_sim_bridge.body.ros2.refusals import Refusals
from reflexarc_sim_bridge.body.ros2.stamps import ScanStamps

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
        stamps: where it notes by which stamp of the robot's clock a scan is known.
        scanner: what is known of the robot's scanner.
    """

    def __init__(
        self, publisher: "Publisher", stamps: ScanStamps, scanner: RosScanner = STANDARD
    ) -> None:
        self._publisher, self._stamps, self._scanner = publisher, stamps, scanner
        self.scans = 0
        self._refusals = Refusals("a scan")

    @property
    def refused(self) -> Counter[str]:
        """How many were refused, by reason."""
        return self._refusals.counts

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            scan = decode_scan(message.payload, self._scanner)
            payload = encode_scan(scan)
        except UnusableMessageError as error:
            self._refusals.count(str(error))
            return
        self.scans += 1
        self._stamps.note(message.received_ns, scan.stamp_ns)
        self._publisher.put(payload, message.received_ns)
