"""Where a CARMEN scan was made: the robot's pose, its odometry, and how the laser sits on it.

The laser's pose in the robot's frame is (c·dx + s·dy, c·dy − s·dx, θ_laser − θ_robot), with dx, dy
from the robot to the laser and c, s the cosine and sine of θ_robot.
"""

import math
from typing import NamedTuple

from reflexarc_logs.importing.carmen_lines import LaserLine
from reflexarc_logs.importing.scan_line import TimedPose, finite
from reflexarc_runtime.sensing.mounting import CENTRED, Mount

FARTHEST_MOUNT_M = 2.0
"""A laser farther from the robot's middle is not on it: its pose is one that a mapper corrected."""

_DECIMALS = 4
"""Of metres and radians. The file has six; the last ones change from line to line."""


class Places(NamedTuple):
    """What the poses of a line say."""

    pose: TimedPose | None = None
    odometry: TimedPose | None = None
    """None if the line has none of its own."""
    mount: Mount = CENTRED


def places_of(line: LaserLine, time_ns: int | None) -> Places:
    """What the poses of a line say.

    Raises:
        BrokenLineError: a word is no finite number.
    """
    if not line.places:
        return Places()
    x_m, y_m, heading_rad, *own = finite(line.places)
    laser = TimedPose(x_m, y_m, heading_rad, time_ns)
    robot = TimedPose(own[0], own[1], own[2], time_ns)
    if line.settings is not None and math.dist(laser[:2], robot[:2]) <= FARTHEST_MOUNT_M:
        return Places(robot, None, _mount(laser, robot))
    repeated = line.places[:3] == line.places[3:]
    return Places(laser, None if repeated else robot)


def _mount(laser: TimedPose, robot: TimedPose) -> Mount:
    cos, sin = math.cos(robot.heading_rad), math.sin(robot.heading_rad)
    dx_m, dy_m = laser.x_m - robot.x_m, laser.y_m - robot.y_m
    turned_rad = math.remainder(laser.heading_rad - robot.heading_rad, math.tau)
    ahead_m, left_m = cos * dx_m + sin * dy_m, cos * dy_m - sin * dx_m
    return Mount(_rounded(ahead_m), _rounded(left_m), _rounded(turned_rad))


def _rounded(number: float) -> float:
    return round(number, _DECIMALS) + 0.0  # never -0.0
