"""ROS 2 messages by another library than ours: pycdr2 in place of rosbags, from the .msg files."""

import math
from dataclasses import dataclass, field

from pycdr2 import IdlStruct
from pycdr2.types import array, float32, float64, int32, sequence, uint32


@dataclass
class Time(IdlStruct, typename="builtin_interfaces/Time"):
    sec: int32 = 0
    nanosec: uint32 = 0


@dataclass
class Header(IdlStruct, typename="std_msgs/Header"):
    stamp: Time = field(default_factory=Time)
    frame_id: str = "laser"


@dataclass
class LaserScan(IdlStruct, typename="sensor_msgs/LaserScan"):
    header: Header
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs/Vector3"):
    x: float64
    y: float64
    z: float64


@dataclass
class Twist(IdlStruct, typename="geometry_msgs/Twist"):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistStamped(IdlStruct, typename="geometry_msgs/TwistStamped"):
    header: Header
    twist: Twist


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs/Quaternion"):
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@dataclass
class Pose(IdlStruct, typename="geometry_msgs/Pose"):
    position: Vector3  # geometry_msgs/Point has the same three numbers
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename="geometry_msgs/PoseWithCovariance"):
    pose: Pose
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class TwistWithCovariance(IdlStruct, typename="geometry_msgs/TwistWithCovariance"):
    twist: Twist
    covariance: array[float64, 36] = field(default_factory=lambda: [0.0] * 36)


@dataclass
class Odometry(IdlStruct, typename="nav_msgs/Odometry"):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


def moving_odometry(
    linear_mps: float = 0.0,
    lateral_mps: float = 0.0,
    angular_radps: float = 0.0,
    frame: str = "base_link",
) -> bytes:
    """`nav_msgs/Odometry` of a base that is somewhere, with covariances that are not 0."""
    pose = Pose(Vector3(3.0, -4.0, 0.0), Quaternion())
    twist = Twist(Vector3(linear_mps, lateral_mps, 0.0), Vector3(0.0, 0.0, angular_radps))
    covariance = [0.5] * 36
    return Odometry(
        Header(),
        frame,
        PoseWithCovariance(pose, covariance),
        TwistWithCovariance(twist, covariance),
    ).serialize()


@dataclass
class Transform(IdlStruct, typename="geometry_msgs/Transform"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs/TransformStamped"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs/TFMessage"):
    transforms: sequence[TransformStamped]


def odometry(
    x_m: float = 1.0,
    y_m: float = 2.0,
    *,
    turn: Quaternion | None = None,
    frame: str = "odom",
    stamp: Time | None = None,
) -> Odometry:
    """A place that a robot says it has."""
    pose = Pose(Vector3(x_m, y_m, 0.0), turn or Quaternion())
    still = Twist(Vector3(0.0, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))
    head = Header(stamp or Time(), frame)
    return Odometry(head, "base_link", PoseWithCovariance(pose), TwistWithCovariance(still))


def transform(
    child: str, x_m: float = 0.0, *, parent: str = "base_link", turn: Quaternion | None = None
) -> TransformStamped:
    """Where a frame is in another one."""
    placed = Transform(Vector3(x_m, 0.0, 0.0), turn or Quaternion())
    return TransformStamped(Header(Time(5, 6), parent), child, placed)


def laser_scan(
    ranges_m: list[float],
    *,
    start_rad: float = -math.pi / 2,
    step_rad: float | None = None,
    limits_m: tuple[float, float] = (0.1, 10.0),
    stamp: Time | None = None,
) -> LaserScan:
    """A scan over half a circle ahead, unless told otherwise."""
    step = math.pi / max(len(ranges_m) - 1, 1) if step_rad is None else step_rad
    end_rad = start_rad + (len(ranges_m) - 1) * step
    head = Header(stamp or Time())
    return LaserScan(head, start_rad, end_rad, step, 0.0, 0.1, *limits_m, ranges_m, [])
