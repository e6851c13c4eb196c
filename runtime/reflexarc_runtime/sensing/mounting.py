"""How a scanner sits on its robot: where, turned by how much, and whether upside down."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from foxglove_schemas_protobuf.Pose_pb2 import Pose

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.sensing.scan import IGNORED_M, Scan, UnusableScanError

LEAST_UPRIGHT = math.cos(math.radians(15.0))
"""A scanner that is tilted by more than 15° scans the floor, or the sky."""

FARTHEST_M = 10.0
"""A pose that puts a scanner farther from its robot's centre is one on a map."""

_require = partial(require, error=UsageError)


@dataclass(frozen=True)
class Mount:
    """Where a scanner sits on its robot, whose frame has x ahead and y to the left."""

    x_m: float = 0.0
    """Ahead of the point about which the robot turns."""
    y_m: float = 0.0
    """To the left of it."""
    yaw_rad: float = 0.0
    """Bearing in which it looks, counter-clockwise; π: backwards."""
    upside_down: bool = False
    """Whether it hangs upside down: its left is then the robot's right."""

    def __post_init__(self) -> None:
        for name in ("x_m", "y_m", "yaw_rad"):
            value = getattr(self, name)
            _require(math.isfinite(value), f"mount.{name}", "a finite number", value)


CENTRED = Mount()
"""In the middle of the robot, looking ahead."""


@dataclass(frozen=True)
class Sector:
    """A part of a sweep, counter-clockwise from its right edge to its left one."""

    right_rad: float
    left_rad: float

    def __post_init__(self) -> None:
        width_rad = self.left_rad - self.right_rad
        fits = math.isfinite(self.right_rad) and 0.0 <= width_rad <= 2.0 * math.pi
        got = (self.right_rad, self.left_rad)
        _require(fits, "sector", "right edge, then left edge, at most a turn", got)


def mount_of(pose: Pose) -> Mount:
    """How a scanner sits by the pose of its sweep's origin (`foxglove.LaserScan.pose`).

    A pose that was left out (all zeros) is the robot's centre, looking ahead.

    Raises:
        UnusableScanError: no pose, one on a map, or a scanner that is neither upright nor upside
            down.
    """
    q, place = pose.orientation, pose.position
    return _mount((place.x, place.y, place.z), (q.x, q.y, q.z, q.w))


@lru_cache(maxsize=16)
def _mount(place_m: tuple[float, ...], turn: tuple[float, ...]) -> Mount:
    if not all(map(math.isfinite, (*place_m, *turn))):
        raise UnusableScanError("a pose that is not finite")
    place_x_m, place_y_m, _ = place_m
    away_m = math.hypot(place_x_m, place_y_m)
    if away_m > FARTHEST_M:
        raise UnusableScanError(
            f"a scanner {away_m:.1f} m from the robot's centre; --mount if its pose is on a map"
        )
    length = math.hypot(*turn)
    if length == 0.0:
        return Mount(place_x_m, place_y_m)
    x, y, z, w = (part / length for part in turn)
    upright = 1.0 - 2.0 * (x * x + y * y)
    if abs(upright) < LEAST_UPRIGHT:
        raise UnusableScanError(
            f"a scanner tilted by {math.degrees(math.acos(upright)):.0f}°: its plane is not the "
            "ground's"
        )
    yaw_rad = math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    return Mount(place_x_m, place_y_m, yaw_rad, upright < 0.0)


def pose_of(mount: Mount) -> Pose:
    """The pose that says how a scanner sits; see `mount_of`."""
    pose, half_rad = Pose(), 0.5 * mount.yaw_rad
    pose.position.x, pose.position.y = mount.x_m, mount.y_m
    cos, sin = math.cos(half_rad), math.sin(half_rad)
    if mount.upside_down:  # half a turn about x first, then the yaw about z
        pose.orientation.x, pose.orientation.y = cos, sin
    else:
        pose.orientation.w, pose.orientation.z = cos, sin
    return pose


def mounted(scan: Scan, mount: Mount) -> Scan:
    """A scan of a scanner's own frame in the robot's."""
    if mount == CENTRED:
        return scan
    start_rad, end_rad, ranges_m = scan.start_rad, scan.end_rad, scan.ranges_m
    if mount.upside_down:
        start_rad, end_rad, ranges_m = -end_rad, -start_rad, ranges_m[::-1]
    yaw_rad = math.remainder(mount.yaw_rad, 2.0 * math.pi)
    return Scan(start_rad + yaw_rad, end_rad + yaw_rad, ranges_m, mount.x_m, mount.y_m)


def without(scan: Scan, sectors: tuple[Sector, ...]) -> Scan:
    """A scan that knows nothing of some sectors: what the robot sees of itself there is left out.

    Bearings are the robot's, from where the scanner sits.
    """
    if not sectors:
        return scan
    bearings_rad = scan.start_rad + scan.step_rad * np.arange(len(scan.ranges_m))
    ranges_m = scan.ranges_m.copy()
    for sector in sectors:
        offset_rad = np.mod(bearings_rad - sector.right_rad, 2.0 * math.pi)
        ranges_m[offset_rad <= sector.left_rad - sector.right_rad] = IGNORED_M
    return replace(scan, ranges_m=ranges_m)
