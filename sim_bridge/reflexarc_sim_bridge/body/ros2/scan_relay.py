"""The robot's scans, passed on to our bus as they come."""

from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.cdr import UnusableMessageError
from reflexarc_sim_bridge.body.ros2.messages import (
    STANDARD,
    RosScan,
    RosScanner,
    decode_scan,
    encode_scan,
)
from reflexarc_sim_bridge.body.ros2.mounts import Mounts
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
        mounts: what the robot says of how it sits.
    """

    def __init__(
        self,
        publisher: "Publisher",
        stamps: ScanStamps,
        scanner: RosScanner = STANDARD,
        mounts: Mounts | None = None,
    ) -> None:
        self._publisher, self._stamps, self._scanner = publisher, stamps, scanner
        self._mounts = mounts
        self.scans = 0
        self._refusals = Refusals("a scan")

    @property
    def refused(self) -> Counter[str]:
        """How many were refused, by reason."""
        return self._refusals.counts

    def _decode(self, message: Message) -> RosScan:
        mounts, now_ns = self._mounts, message.received_ns
        if mounts is None:
            return decode_scan(message.payload, self._scanner)
        return decode_scan(message.payload, self._scanner, lambda frame: mounts.of(frame, now_ns))

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            scan = self._decode(message)
            payload = encode_scan(scan)
        except UnusableMessageError as error:
            self._refusals.count(str(error), message.received_ns)
            return
        self.scans += 1
        self._stamps.note(message.received_ns, scan.stamp_ns)
        self._publisher.put(payload, message.received_ns)
