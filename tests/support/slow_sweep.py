"""A sweep the long way: the body put at many places along its path, the points looked at there."""

import math
from collections.abc import Iterable

from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.sweep import Speeds

Point = tuple[float, float]


def place_at(twist: Speeds, time_s: float) -> tuple[float, float, float]:
    """Where a body is after a time, and which way it looks: x, y, heading."""
    linear, lateral, angular = twist
    turned = angular * time_s
    if abs(turned) < 1e-12:
        return linear * time_s, lateral * time_s, 0.0
    sin, cos = math.sin(turned), 1.0 - math.cos(turned)
    return (
        (linear * sin - lateral * cos) / angular,
        (linear * cos + lateral * sin) / angular,
        turned,
    )


def seen_from(point: Point, place: tuple[float, float, float]) -> Point:
    """A point in the frame of a body at a place."""
    x, y, heading = place
    from_x, from_y = point[0] - x, point[1] - y
    sin, cos = math.sin(heading), math.cos(heading)
    return cos * from_x + sin * from_y, cos * from_y - sin * from_x


def is_within(point: Point, footprint: Footprint, margin_m: float) -> bool:
    """Whether a point lies within the outline, widened."""
    x, y = point
    if footprint.ahead_m or footprint.behind_m or footprint.half_width_m:
        front, rear = footprint.ahead_m + margin_m, footprint.behind_m + margin_m
        return -rear < x < front and abs(y) < footprint.half_width_m + margin_m
    return math.hypot(x, y) < footprint.radius_m + margin_m


def off_the_body_m(point: Point, footprint: Footprint) -> float:
    """Distance from a point to the body itself; to its middle for what is inside."""
    x, y = point
    if footprint.radius_m:
        return math.hypot(x, y)
    nearest_x = min(max(x, -footprint.behind_m), footprint.ahead_m)
    nearest_y = min(max(y, -footprint.half_width_m), footprint.half_width_m)
    off_m = math.hypot(x - nearest_x, y - nearest_y)
    return off_m if off_m > 0.0 else math.hypot(x, y) - 1e3


def first_touch_s(
    points: Iterable[Point],
    footprint: Footprint,
    margin_m: float,
    twist: Speeds,
    until_s: float,
    step_s: float,
) -> float:
    """When the first point is touched, to within a step; +inf: not before the end."""
    waiting = []
    for point in points:
        if not is_within(point, footprint, margin_m):
            waiting.append(point)
            continue
        before, after = (
            off_the_body_m(seen_from(point, place_at(twist, t)), footprint) for t in (0.0, 1e-7)
        )
        if after < before - 1e-12:
            return 0.0
    for step in range(1, math.ceil(until_s / step_s) + 1):
        place = place_at(twist, step * step_s)
        if any(is_within(seen_from(p, place), footprint, margin_m) for p in waiting):
            return step * step_s
    return math.inf
