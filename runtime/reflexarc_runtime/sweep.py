"""When a moving body touches a point: the geometry of the guard, which knows no time and no policy.

Frame: the body's, x ahead, y to the left, metres. A motion is a constant twist (linear, lateral,
angular speed), so the body goes straight, or turns about one point at rest:

    straight:  centre(t) = (v, u) t
    turning:   about c = (−u, v) / ω, by ω t

The answer is the time at the full speed until a point lies within the outline, widened by a margin.
A slower twist of the same shape sweeps the same ground, so this one time serves every speed. A
point that lies within the margin already stops only motions that bring it nearer: whoever stands
too near must be able to leave.

Everything is element by element, so one scan and the scans of many agents give the same.
"""

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.body_spec import Footprint

Floats: TypeAlias = npt.NDArray[np.float64]
"""Numbers of any shape, one a point."""

Speeds: TypeAlias = tuple[float, float, float]
"""Linear, lateral and angular speed: m/s, m/s, rad/s."""

STRAIGHT_RADIUS_M = 1e5
"""On a larger circle 10 m are straight to within half a millimetre."""

_FULL_TURN = 2.0 * math.pi


def touch_times_s(
    x_m: Floats, y_m: Floats, footprint: Footprint, margin_m: float, twist: Speeds
) -> Floats:
    """When each point is touched: 0 or less means now, +inf never.

    Args:
        x_m: of the points, any shape.
        y_m: of the points, the same shape.
        footprint: outline of the body.
        margin_m: by how much the outline is widened.
        twist: how the body moves.
    """
    linear, lateral, angular = twist
    speed = math.hypot(linear, lateral)
    straight = speed >= STRAIGHT_RADIUS_M * abs(angular)
    if is_rectangle(footprint):
        sides = _sides_m(footprint, margin_m)
        reached = (_straight_box if straight else _turning_box)(x_m, y_m, sides, twist)
        return _leaving_box(x_m, y_m, footprint, sides, twist, reached)
    if speed == 0.0:  # a disc that turns on the spot sweeps nothing
        return np.full(np.shape(x_m), math.inf)
    reach_m = footprint.radius_m + margin_m
    return (_straight_disc if straight else _turning_disc)(x_m, y_m, reach_m, twist)


def swept_speed_mps(footprint: Footprint, twist: Speeds) -> float:
    """Speed of the fastest point of the outline: what has to be braked."""
    linear, lateral, angular = twist
    turning = abs(angular) * footprint.reach_m if is_rectangle(footprint) else 0.0
    return math.hypot(linear, lateral) + turning


def is_rectangle(footprint: Footprint) -> bool:
    """Whether an outline is a rectangle, no disc or point."""
    return bool(footprint.ahead_m or footprint.behind_m or footprint.half_width_m)


def _straight_disc(x_m: Floats, y_m: Floats, reach_m: float, twist: Speeds) -> Floats:
    linear, lateral, _ = twist
    speed = math.hypot(linear, lateral)
    ahead_x, ahead_y = linear / speed, lateral / speed
    along = x_m * ahead_x + y_m * ahead_y
    across = y_m * ahead_x - x_m * ahead_y
    within = reach_m * reach_m - across * across
    entry = (along - np.sqrt(np.maximum(within, 0.0))) / speed
    return np.where((within > 0.0) & (along > 0.0), entry, math.inf)


def _turning_disc(x_m: Floats, y_m: Floats, reach_m: float, twist: Speeds) -> Floats:
    """The centre goes along a circle about c; a point is touched along a part of that circle."""
    linear, lateral, angular = twist
    radius = math.hypot(linear, lateral) / abs(angular)
    from_x, from_y = x_m + lateral / angular, y_m - linear / angular  # from c to the point
    distance = np.maximum(np.hypot(from_x, from_y), 1e-12)
    start = math.atan2(-linear / angular, lateral / angular)  # from c to the body
    turn = (np.arctan2(from_y, from_x) - start) * math.copysign(1.0, angular) % _FULL_TURN
    share = (radius * radius + distance * distance - reach_m * reach_m) / (2.0 * radius * distance)
    half = np.arccos(np.clip(share, -1.0, 1.0))
    touched = share < 1.0
    inside = x_m * x_m + y_m * y_m < reach_m * reach_m
    nearer = x_m * linear + y_m * lateral > 0.0
    entry = np.where(inside, np.where(nearer, 0.0, math.inf), (turn - half) % _FULL_TURN)
    return np.where(touched | inside, entry / abs(angular), math.inf)


Sides: TypeAlias = tuple[float, float, float]
"""Of a widened rectangle: to the front, to the rear, to either side."""


def _sides_m(footprint: Footprint, margin_m: float) -> Sides:
    front, rear = footprint.ahead_m + margin_m, footprint.behind_m + margin_m
    return front, rear, footprint.half_width_m + margin_m


def _straight_box(x_m: Floats, y_m: Floats, sides: Sides, twist: Speeds) -> Floats:
    """The span of time within each pair of sides; what is within both is touched."""
    front, rear, side = sides
    enters, leaves = _between(x_m, -rear, front, twist[0])
    enters_y, leaves_y = _between(y_m, -side, side, twist[1])
    enters, leaves = np.maximum(enters, enters_y), np.minimum(leaves, leaves_y)
    return np.where((enters < leaves) & (enters >= 0.0), enters, math.inf)


def _between(place: Floats, low: float, high: float, speed: float) -> tuple[Floats, Floats]:
    """From when to when a point at `place`, as the body comes at `speed`, is between two sides."""
    if speed == 0.0:
        is_between = (low < place) & (place < high)
        return np.where(is_between, -math.inf, math.inf), np.where(is_between, math.inf, -math.inf)
    first, second = (place - high) / speed, (place - low) / speed
    return np.minimum(first, second), np.maximum(first, second)


def _turning_box(x_m: Floats, y_m: Floats, sides: Sides, twist: Speeds) -> Floats:
    """In the body's frame a point goes along a circle about c; where that crosses a side."""
    linear, lateral, angular = twist
    centre_x, centre_y = -lateral / angular, linear / angular
    from_x, from_y = x_m - centre_x, y_m - centre_y
    distance = np.maximum(np.hypot(from_x, from_y), 1e-12)
    start = np.arctan2(from_y, from_x)
    front, rear, side = sides
    first = np.full(np.shape(x_m), math.inf)
    for edge, low, high, turned in (
        (front - centre_x, -side - centre_y, side - centre_y, 0.0),
        (-rear - centre_x, -side - centre_y, side - centre_y, 0.0),
        (side - centre_y, -front + centre_x, rear + centre_x, 0.5 * math.pi),
        (-side - centre_y, -front + centre_x, rear + centre_x, 0.5 * math.pi),
    ):
        # The last two are the first two seen from a frame turned by a quarter.
        half = np.arccos(np.clip(edge / distance, -1.0, 1.0))
        for angle in (half, -half):
            there = distance * np.sin(angle)
            crosses = (np.abs(edge) <= distance) & (low <= there) & (there <= high)
            turn = (start - (angle + turned)) * math.copysign(1.0, angular) % _FULL_TURN
            first = np.where(crosses, np.minimum(first, turn / abs(angular)), first)
    return first


def _leaving_box(
    x_m: Floats, y_m: Floats, footprint: Footprint, sides: Sides, twist: Speeds, reached: Floats
) -> Floats:
    """What lies within the widened outline stops a motion only if the outline comes nearer."""
    front, rear, side = sides
    inside = (-rear < x_m) & (x_m < front) & (np.abs(y_m) < side)
    off_x = x_m - np.clip(x_m, -footprint.behind_m, footprint.ahead_m)
    off_y = y_m - np.clip(y_m, -footprint.half_width_m, footprint.half_width_m)
    within = (off_x == 0.0) & (off_y == 0.0)  # within the body itself: whatever comes out ahead
    off_x, off_y = np.where(within, x_m, off_x), np.where(within, y_m, off_y)
    linear, lateral, angular = twist
    nearer = off_x * (linear - angular * y_m) + off_y * (lateral + angular * x_m) > 0.0
    return np.where(inside, np.where(nearer, 0.0, math.inf), reached)
