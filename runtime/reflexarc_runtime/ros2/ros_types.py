"""The message types of ROS 2 that we read and write, and their hashes."""

from dataclasses import dataclass, replace

NO_TYPE_HASH = "TypeHashNotSupported"
"""What Humble's rmw_zenoh writes in place of a hash: hashes came with Iron (REP-2016)."""


@dataclass(frozen=True, slots=True)
class RosType:
    """A message type: its name and its version-1 hash (REP-2016, RIHS01)."""

    name: str
    """As `ros2 interface` spells it: `sensor_msgs/msg/LaserScan`."""
    type_hash: str
    """As `ros2 topic info --verbose` prints it on Jazzy. It changes with the definition only."""

    def without_hash(self) -> "RosType":
        """The same as a distribution spells it that has no hashes."""
        return replace(self, type_hash=NO_TYPE_HASH)


LASER_SCAN = RosType(
    "sensor_msgs/msg/LaserScan",
    "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
)
TWIST = RosType(
    "geometry_msgs/msg/Twist",
    "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
)
TWIST_STAMPED = RosType(
    "geometry_msgs/msg/TwistStamped",
    "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
)
ODOMETRY = RosType(
    "nav_msgs/msg/Odometry",
    "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
)
TF_MESSAGE = RosType(
    "tf2_msgs/msg/TFMessage",
    "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
)
IMAGE = RosType(
    "sensor_msgs/msg/Image",
    "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
)
COMPRESSED_IMAGE = RosType(
    "sensor_msgs/msg/CompressedImage",
    "RIHS01_15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
)
