"""The flags that say which topics of a bag of ROS 2 are the robot's own."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reflexarc.wiring.scan_flags import ScanFlags

if TYPE_CHECKING:
    from reflexarc_logs.bags.bag_streams import BagWishes


@dataclass(frozen=True)
class BagFlags:
    """What to take out of a bag of ROS 2, and what its scanner means."""

    scan: str = ""
    """Of a bag: the topic that becomes the log's scan; by default the only one, or /scan."""
    odometry: str = ""
    """Of a bag: the topic that becomes the log's odometry; by default the only one, or /odom."""
    base: str = "base_link"
    """Of a bag: the robot's own frame, on which its scanners sit."""
    scanner: ScanFlags = field(default_factory=ScanFlags)

    def wishes(self, robot: str) -> "BagWishes":
        """What is wanted of the bag.

        Raises:
            UsageError: a flag is out of range.
        """
        from reflexarc_logs.bags.bag_streams import BagWishes
        from reflexarc_runtime.ros2.laser_scan import RosScanner

        flags = self.scanner
        scanner = RosScanner(flags.meaning, flags.known_mount, flags.ignored)
        return BagWishes(robot, self.scan, self.odometry, scanner, self.base)
