"""How far along each beam a motion may touch something: a bound above what `sweep` finds.

What is measured farther away than that, on every beam, is not touched: one comparison instead of
the geometry. The sense's beams, the body and its motions are the same from tick to tick, so the
bound is worked out once, the plain way: the outline is put at many places along its path, widened
by as much as it can move from one place to the next, and each beam ends where it leaves the last.

    outline at time t  ⊂  outline at the nearest place, widened by  ½ · step · speed

The bound says "free" too seldom, never too often: who is refused by it asks `sweep`. Decisions
are the same with it and without it; it only takes less time.
"""

import math
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from reflexarc_runtime.beams import Fan
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.sweep import STRAIGHT_RADIUS_M, Floats, Speeds, is_rectangle

STEP_M = 0.01
"""Length of a step along the path, at the fastest point of the outline."""
MOST_STEPS = 256
"""A longer path is cut into longer steps, and its bound is wider."""
HAIR_M = 0.002
"""By how much a bound is wider than it need be: more than `sweep` rounds by."""
MOST_BEAMS = 1024
"""No bound is worked out for more: it would take longer than a tick may."""
MOST_FANS = 4
"""How many senses are remembered. A sender of ever new angles gains nothing by it."""
USES = 32
"""How often a fan is used before its bound is worked out, which takes a few such checks."""


def reaches_m(
    fan: Fan, footprint: Footprint, margin_m: float, twist: Speeds, ways_s: list[float]
) -> Floats:
    """For each way, how far along each beam the body may touch something: (ways, beams).

    NaN, which nothing exceeds, where no bound is known.

    Args:
        fan: the beams.
        footprint: outline of the body.
        margin_m: by how much it is widened.
        twist: how the body moves.
        ways_s: for how long, the longest one last.
    """
    shape = (len(ways_s), len(fan.cos))
    if sweeps_nothing(footprint, twist):
        return np.full(shape, -math.inf)
    speed_mps, size_m = _fastest(footprint, margin_m, twist)
    steps = _steps(ways_s[-1] * speed_mps)
    step_s = ways_s[-1] / steps
    slack_m = 0.5 * step_s * speed_mps + HAIR_M
    if not slack_m <= size_m:  # a body that goes this far in a step is no body: leave it to `sweep`
        return np.full(shape, math.nan)
    times_s: Floats = step_s * np.arange(steps + 1, dtype=np.float64)
    places = _places(twist, times_s)
    leave = _leave_box if is_rectangle(footprint) else _leave_disc
    leave_m = leave(fan, footprint, margin_m + slack_m, places)
    farthest_m = np.maximum.accumulate(leave_m, axis=0)
    last = [min(int(way_s / step_s) + 1, steps) for way_s in ways_s]
    reaches: Floats = farthest_m[last]
    return reaches


def sweeps_nothing(footprint: Footprint, twist: Speeds) -> bool:
    """Whether a motion touches nothing that is not touched already."""
    linear, lateral, angular = twist
    return linear == lateral == 0.0 and (angular == 0.0 or not is_rectangle(footprint))


def _fastest(footprint: Footprint, margin_m: float, twist: Speeds) -> tuple[float, float]:
    """No point of the outline, in steps of less than its size, is faster; and its size."""
    linear, lateral, angular = twist
    size_m = footprint.reach_m + math.sqrt(2.0) * margin_m
    turning_mps = abs(angular) * 2.0 * (size_m + HAIR_M) if is_rectangle(footprint) else 0.0
    return math.hypot(linear, lateral) + turning_mps, size_m + HAIR_M


def _steps(way_m: float) -> int:
    if not way_m < MOST_STEPS * STEP_M:
        return MOST_STEPS
    return max(math.ceil(way_m / STEP_M), 1)


Places: TypeAlias = tuple[Floats, Floats, Floats]
"""Where the body is along its path, (steps, 1) each: x, y, heading."""


def _places(twist: Speeds, times_s: Floats) -> Places:
    linear, lateral, angular = twist
    times_s = times_s[:, np.newaxis]
    if math.hypot(linear, lateral) >= STRAIGHT_RADIUS_M * abs(angular):
        return linear * times_s, lateral * times_s, np.zeros_like(times_s)
    turned = angular * times_s
    sin, versine = np.sin(turned), 2.0 * np.sin(0.5 * turned) ** 2
    x_m = (linear * sin - lateral * versine) / angular
    return x_m, (linear * versine + lateral * sin) / angular, turned


def _leave_disc(fan: Fan, footprint: Footprint, wider_m: float, places: Places) -> Floats:
    """Where each beam leaves the disc at each place, (steps, beams); -inf: it does not meet it."""
    x_m, y_m, _ = places
    reach_m = footprint.radius_m + wider_m
    along, across = x_m * fan.cos + y_m * fan.sin, x_m * fan.sin - y_m * fan.cos
    within = reach_m * reach_m - across * across
    return np.where(within >= 0.0, along + np.sqrt(np.maximum(within, 0.0)), -math.inf)


def _leave_box(fan: Fan, footprint: Footprint, wider_m: float, places: Places) -> Floats:
    """The same for a rectangle: where the beam has left the first of its two pairs of sides."""
    x_m, y_m, heading = places
    cos, sin = np.cos(heading), np.sin(heading)
    ahead, across = (
        _not_zero(cos * fan.cos + sin * fan.sin),
        _not_zero(cos * fan.sin - sin * fan.cos),
    )
    from_x, from_y = -(cos * x_m + sin * y_m), sin * x_m - cos * y_m
    front, rear = footprint.ahead_m + wider_m, -footprint.behind_m - wider_m
    side = footprint.half_width_m + wider_m
    one, other = (front - from_x) / ahead, (rear - from_x) / ahead
    left, right = (side - from_y) / across, (-side - from_y) / across
    enters = np.maximum(np.minimum(one, other), np.minimum(left, right))
    leaves: Floats = np.minimum(np.maximum(one, other), np.maximum(left, right))
    return np.where(enters <= leaves, leaves, -math.inf)


def _not_zero(share: Floats) -> Floats:
    """A beam along a side never meets it: it does so very far away."""
    return np.where(np.abs(share) < 1e-12, 1e-12, share)


@dataclass(slots=True)
class _Known:
    """What is known of one fan."""

    uses: int = 0
    reaches_m: dict[int, Floats] = field(default_factory=dict)


class Reaches:
    """The bounds of a few fans, the last ones that were used, each worked out when it pays.

    Args:
        work_out: the bounds of an action along a fan's beams.
    """

    def __init__(self, work_out: Callable[[Fan, int], Floats]) -> None:
        self._work_out = work_out
        self._fans: OrderedDict[Fan, _Known] = OrderedDict()

    def of(self, fan: Fan, action: int) -> Floats | None:
        """The bounds of an action; None while a fan has not been used often, or is too large."""
        known = self._fans.get(fan)
        if known is None:
            self._add(fan)
            return None
        self._fans.move_to_end(fan)
        reaches = known.reaches_m.get(action)
        return self._later(fan, known, action) if reaches is None else reaches

    def prepare(self, fan: Fan, actions: int) -> None:
        """Work out all that a fan will need."""
        self._add(fan).uses = USES
        for action in range(actions):
            self.of(fan, action)

    def _add(self, fan: Fan) -> _Known:
        if len(self._fans) >= MOST_FANS:
            self._fans.popitem(last=False)
        return self._fans.setdefault(fan, _Known())

    def _later(self, fan: Fan, known: _Known, action: int) -> Floats | None:
        known.uses += 1
        if known.uses < USES or len(fan.cos) > MOST_BEAMS:
            return None
        reaches = known.reaches_m[action] = self._work_out(fan, action)
        return reaches
