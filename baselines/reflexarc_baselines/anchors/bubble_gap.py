"""Follow the gap as racers know it: a bubble around the nearest point, then the longest free run.

Source: the F1TENTH course (f1tenth.org, "Follow the Gap"), after Sezer & Gokasan 2012:

1. rays that end within a bubble of radius r around the nearest point count as 0,
2. so do those that end nearer than a threshold,
3. of the longest run of rays that are not 0, the first of equals, the middle is where it heads: T.

Adapted: the bearing is not a steering angle but a wish to step aside.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.anchors.gap_follower import GapFollower
from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.rays import bearings_rad
from reflexarc_runtime.arrays import Mask

_SOURCE = "F1TENTH course, Follow the Gap, after V. Sezer, M. Gokasan 2012"


def longest_run(is_free: Mask) -> tuple[Floats, Floats]:
    """Middle and length of the longest run of true values: (n,) and (n,), in places of the row."""
    run = np.zeros(len(is_free), np.float32)
    length, last = run.copy(), run.copy()
    for place in range(is_free.shape[1]):
        run = np.where(is_free[:, place], run + np.float32(1.0), np.float32(0.0))
        is_longer = run > length
        length, last = np.where(is_longer, run, length), np.where(is_longer, place, last)
    middle: Floats = last - (length - np.float32(1.0)) / np.float32(2.0)
    return middle.astype(np.float32), length


@dataclass(frozen=True)
class BubbleGap(GapFollower):
    """Heads for the middle of the longest run of rays that are free."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "bubble_m": Span(0.0, 1.0),
        "threshold_m": Span(0.2, 4.0),
        "dead_band_rad": Span(0.02, 0.8),
    }

    bubble_m: float = 0.996
    """r: radius of the bubble."""
    threshold_m: float = 1.12
    """Rays that end nearer are not free."""
    dead_band_rad: float = 0.22
    """Bearing below which it stays on its way."""

    def heading_rad(self, distances_m: Floats) -> Floats:
        """Bearing of the run's middle, left positive; 0 if no ray is free: (n,)."""
        bearings = bearings_rad(self.contract.retina)
        is_free = ~self._in_bubble(distances_m, bearings) & (distances_m >= self.threshold_m)
        middle, length = longest_run(is_free)
        heading = bearings[0] + middle * (bearings[1] - bearings[0])
        return np.where(length > 0.0, heading, np.float32(0.0)).astype(np.float32)

    def _in_bubble(self, distances_m: Floats, bearings_rad: Floats) -> Mask:
        x_m, y_m = distances_m * np.cos(bearings_rad), distances_m * np.sin(bearings_rad)
        nearest = distances_m.argmin(axis=1)[:, np.newaxis]
        dx_m = x_m - np.take_along_axis(x_m, nearest, 1)
        dy_m = y_m - np.take_along_axis(y_m, nearest, 1)
        inside: Mask = np.hypot(dx_m, dy_m) < np.float32(self.bubble_m)
        return inside
