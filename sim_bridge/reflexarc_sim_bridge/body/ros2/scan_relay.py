"""The robot's scans, passed on to our bus as they come, with the time at which they were taken.

That time is on this machine's clock: the arrival, minus how far behind the driver's best the scan
came, by the stamp in its header. So runtime and gate both see a queue between driver and bridge.
"""

from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.backlog import NO_LAG
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.laser_scan import (
    STANDARD,
    RosScan,
    RosScanner,
    decode_scan,
    encode_scan,
)
from reflexarc_runtime.ros2.mounts import BASE, Mounts
from reflexarc_sim_bridge.body.ros2.refusals import Refusals
from reflexarc_sim_bridge.body.ros2.stamps import ScanStamps

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

SILENCE_NS = 1_000_000_000
"""A driver that was silent for longer may have begun anew, with another clock."""


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
        stamps: where it notes by which stamp of the robot's clock a scan is known.
        scanner: what is known of the robot's scanner.
        mounts: what the robot says of how it sits.
        heeds_stamps: whether the stamps in the headers count; not those of a simulator whose time
            runs slower than ours.
    """

    def __init__(
        self,
        publisher: "Publisher",
        stamps: ScanStamps,
        scanner: RosScanner = STANDARD,
        mounts: Mounts | None = None,
        *,
        heeds_stamps: bool = True,
    ) -> None:
        self._publisher, self._stamps, self._scanner = publisher, stamps, scanner
        self._mounts = mounts
        self._heeds_stamps = heeds_stamps
        self._backlog = NO_LAG
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
            payload = encode_scan(scan, self._mounts.base if self._mounts else BASE)
        except UnusableMessageError as error:
            self._refusals.count(str(error), message.received_ns)
            return
        self.scans += 1
        taken_ns = self._taken_ns(scan.stamp_ns, message.received_ns)
        self._stamps.note(taken_ns, scan.stamp_ns)
        self._publisher.put(payload, taken_ns)

    def _taken_ns(self, stamp_ns: int, received_ns: int) -> int:
        """When a scan would have come without a queue."""
        if not self._heeds_stamps:
            return received_ns
        self._backlog = self._backlog.after(max(0, stamp_ns), received_ns, SILENCE_NS)
        return max(0, received_ns - self._backlog.behind_ns)
