"""Which topics of a robot a bridge hears and speaks on, and how they are encoded on Zenoh."""

from dataclasses import dataclass

from reflexarc_runtime.ros2.laser_scan import STANDARD, RosScanner
from reflexarc_runtime.ros2.mounts import BASE
from reflexarc_runtime.ros2.ros_types import (
    LASER_SCAN,
    ODOMETRY,
    TF_MESSAGE,
    TWIST,
    TWIST_STAMPED,
    RosType,
)
from reflexarc_sim_bridge.body.ros2.key_expressions import BEST_EFFORT, LATCHED, RELIABLE, Port
from reflexarc_sim_bridge.body.ros2.stamps import StampRule
from reflexarc_sim_bridge.body.ros2.wires import Wire


@dataclass(frozen=True, slots=True)
class Route:
    """The topics of a robot: full names, with their leading slash."""

    wire: Wire
    scan: str
    """Of `sensor_msgs/LaserScan`."""
    command: str
    """By which the robot drives."""
    stamped: bool = False
    """Whether that one takes `geometry_msgs/TwistStamped`, or `Twist`."""
    stamp: StampRule = StampRule.SCAN
    """What they are stamped with."""
    odometry: str = ""
    """Of `nav_msgs/Odometry`; empty: not heard."""
    tf: str = ""
    """Of `tf2_msgs/TFMessage`; the same with `_static` behind it is heard as well. Empty: none."""
    base: str = BASE
    """The robot's own frame among its transforms."""
    scanner: RosScanner = STANDARD
    """What is known of the scanner beside what its messages say."""
    heeds_stamps: bool = True
    """Whether the stamps of scans tell how old they are."""

    @property
    def command_type(self) -> RosType:
        """Type of the commands."""
        return TWIST_STAMPED if self.stamped else TWIST

    @property
    def tf_static(self) -> str:
        """Of the transforms that never change."""
        return f"{self.tf}_static" if self.tf else ""

    @property
    def scan_key(self) -> str:
        """Key of the scans."""
        return self.wire.key(self.scan, LASER_SCAN)

    @property
    def command_key(self) -> str:
        """Key of the commands."""
        return self.wire.key(self.command, self.command_type)

    @property
    def odometry_key(self) -> str:
        """Key of the odometry; empty without one."""
        return self.wire.key(self.odometry, ODOMETRY) if self.odometry else ""

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of all of them."""
        return tuple(self.wire.key(port.topic, port.kind) for port in (*self.heard, *self.spoken))

    @property
    def heard(self) -> tuple[Port, ...]:
        """What we subscribe to."""
        wanted = (
            Port(self.scan, LASER_SCAN, BEST_EFFORT),
            Port(self.odometry, ODOMETRY, BEST_EFFORT),
            Port(self.tf, TF_MESSAGE, BEST_EFFORT),
            Port(self.tf_static, TF_MESSAGE, LATCHED),
        )
        return tuple(port for port in wanted if port.topic)

    @property
    def spoken(self) -> tuple[Port, ...]:
        """What we publish."""
        return (Port(self.command, self.command_type, RELIABLE),)

    def tokens(self, session_id: str) -> tuple[str, ...]:
        """Liveliness tokens by which we appear in the robot's ROS graph."""
        return self.wire.tokens(session_id, self.heard, self.spoken)
