"""The path that a body takes when it does not take a commanded motion at once.

Its linear and its lateral speed, each by itself, change by at most the deceleration a:

    v(t) = v₀                              until the command is felt
           v₀ + clip(v₁ − v₀, ± a t)       while it is obeyed
           v₂ − clip(v₂, ± a t)            then it brakes, from the speed v₂ that it has come to

A change of side is a curve, which neither the old motion's straight way covers nor the new one's.
Frame: the body's where the ranges were measured. The turn is felt at once; while it brakes it turns
as far as the arc of its path does.

Pure, and about one robot. What the body really does is not known; this is what it was told, by a
model of it, so whoever pushes it is not in it.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.sweep import Floats, Speeds, is_rectangle

STEP_M = 0.03
"""Between two places of the path: a disc of 5 cm misses 2 mm of what lies between."""
MOST_STEPS = 64
STILL = (0.0, 0.0, 0.0)
_SAME_MPS = 1e-6
_HAIR_M = 1e-6


@dataclass(frozen=True, slots=True)
class Moving:
    """How a body is believed to move."""

    twist: Speeds
    """At the time below."""
    commanded: Speeds
    """What it was told then."""
    at_ns: int

    def later(self, now_ns: int, valid_ns: int, braking_mps2: float) -> Speeds:
        """How it moves at a later time: it follows the command while that is valid, then brakes."""
        passed_ns = max(now_ns - self.at_ns, 0)
        obeyed_s, braked_s = min(passed_ns, valid_ns) * 1e-9, max(passed_ns - valid_ns, 0) * 1e-9
        twist = followed(self.twist, self.commanded, braking_mps2 * obeyed_s)
        return followed(twist, STILL, braking_mps2 * braked_s) if braked_s else twist


def followed(now: Speeds, wanted: Speeds, most_mps: float) -> Speeds:
    """The motion after both speeds have changed by at most so much; the turn is taken at once."""
    linear, lateral = (
        before + min(max(after - before, -most_mps), most_mps)
        for before, after in zip(now[:2], wanted[:2], strict=True)
    )
    return linear, lateral, wanted[2]


def is_same(now: Speeds, wanted: Speeds) -> bool:
    """Whether a body does already what it is told, so that its path is the straight way."""
    return all(abs(a - b) < _SAME_MPS for a, b in zip(now, wanted, strict=True))


@dataclass(frozen=True, slots=True)
class Order:
    """A motion, and for how long a body does it."""

    twist: Speeds
    felt_s: float
    """From the measurement of the ranges until the body feels it."""
    held_s: float
    """For how long it obeys after that."""


def path(now: Speeds, order: Order, braking_mps2: float) -> Floats:
    """Where the body is at even times until it stands: (places, 3) of x, y, heading."""
    felt_s, ends_s = order.felt_s, order.felt_s + order.held_s
    last = followed(now, order.twist, braking_mps2 * order.held_s)
    brakes_s = max(abs(last[0]), abs(last[1])) / braking_mps2
    fastest_mps = max(math.hypot(*now[:2]), math.hypot(*order.twist[:2]))
    whole_s = ends_s + brakes_s
    steps = min(max(math.ceil(fastest_mps * whole_s / STEP_M), 1), MOST_STEPS)
    step_s = whole_s / steps
    middle_s: Floats = step_s * (np.arange(steps, dtype=np.float64) + 0.5)
    gain_mps = braking_mps2 * np.clip(middle_s - felt_s, 0.0, order.held_s)
    loss_mps = braking_mps2 * np.maximum(middle_s - ends_s, 0.0)
    speeds = [
        _eased(_changed(v, wanted, gain_mps), loss_mps)
        for v, wanted in zip(now[:2], order.twist[:2], strict=True)
    ]
    share = 1.0 - np.clip((middle_s - ends_s) / max(brakes_s, 1e-9), 0.0, 1.0)
    turning = np.where(middle_s < felt_s, now[2], order.twist[2] * share)
    headings = step_s * np.cumsum(turning)
    middle = headings - 0.5 * step_s * turning
    cos, sin = np.cos(middle), np.sin(middle)
    x_m = step_s * np.cumsum(speeds[0] * cos - speeds[1] * sin)
    y_m = step_s * np.cumsum(speeds[0] * sin + speeds[1] * cos)
    return np.stack([x_m, y_m, headings], axis=-1)


def _changed(now: float, wanted: float, gain_mps: Floats) -> Floats:
    change: Floats = np.clip(wanted - now, -gain_mps, gain_mps)
    return now + change


def _eased(speed: Floats, loss_mps: Floats) -> Floats:
    change: Floats = np.clip(speed, -loss_mps, loss_mps)
    return speed - change


def touches(
    x_m: Floats, y_m: Floats, footprint: Footprint, margin_m: float, places: Floats
) -> bool:
    """Whether one of the points comes within the widened outline along a path.

    A point that is within it from the beginning counts once it comes nearer than it was.
    """
    wider_m = margin_m + _between_m(footprint, places)
    here_m = _off_m(x_m, y_m, footprint)
    cos, sin = np.cos(places[:, 2:]), np.sin(places[:, 2:])
    from_x, from_y = x_m - places[:, :1], y_m - places[:, 1:2]
    off_m = _off_m(cos * from_x + sin * from_y, cos * from_y - sin * from_x, footprint)
    return bool((off_m.min(axis=0) < np.minimum(here_m - _HAIR_M, wider_m)).any())


def _between_m(footprint: Footprint, places: Floats) -> float:
    """By how much the outline is widened for what lies between two places."""
    steps_m = np.hypot(np.diff(places[:, 0], prepend=0.0), np.diff(places[:, 1], prepend=0.0))
    longest_m = float(steps_m.max())
    if longest_m > STEP_M * (1.0 + _HAIR_M) or is_rectangle(footprint):
        return 0.5 * max(longest_m, STEP_M)
    return 0.0


def _off_m(x_m: Floats, y_m: Floats, footprint: Footprint) -> Floats:
    """Distance of points from the outline; less than 0 within a disc, 0 within a rectangle."""
    if not is_rectangle(footprint):
        off: Floats = np.hypot(x_m, y_m) - footprint.radius_m
        return off
    off_x = x_m - np.clip(x_m, -footprint.behind_m, footprint.ahead_m)
    off_y = y_m - np.clip(y_m, -footprint.half_width_m, footprint.half_width_m)
    off_m: Floats = np.hypot(off_x, off_y)
    return off_m
