"""Beams: the directions in which a sense measures, and how far it saw in each."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from reflexarc_runtime.sweep import Floats

_SLACK_RAD = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Fan:
    """The directions of a sense's beams."""

    cos: Floats
    """Of the bearings, (beams,)."""
    sin: Floats
    right_rad: float
    """Lowest bearing that is seen."""
    left_rad: float
    """Highest bearing that is seen."""
    blind: tuple[tuple[float, float], ...] = ()
    """Sectors between them, right edge and left edge, in which nothing is seen."""

    def sees(self, bearing_rad: float) -> bool:
        """Whether a bearing lies in the sector that is seen."""
        if any(_lies_in(bearing_rad, *sector) for sector in self.blind):
            return False
        return _lies_in(bearing_rad, self.right_rad, self.left_rad)

    def sees_arc(self, one_rad: float, other_rad: float) -> bool:
        """Whether all between two bearings lies in it. At its very edge the answer is no."""
        if self.blind:
            return False
        low_rad, width_rad = min(one_rad, other_rad), self.left_rad - self.right_rad
        offset_rad = (low_rad - self.right_rad) % (2.0 * math.pi)
        return offset_rad + abs(other_rad - one_rad) <= width_rad


def _lies_in(bearing_rad: float, right_rad: float, left_rad: float) -> bool:
    offset_rad = (bearing_rad - right_rad + _SLACK_RAD) % (2.0 * math.pi)
    return offset_rad <= left_rad - right_rad + 2.0 * _SLACK_RAD


@dataclass(frozen=True, slots=True, eq=False)
class Beams:
    """What was measured: a distance for each direction of a fan."""

    fan: Fan
    ranges_m: Floats
    """(beams,), or (agents, beams): +inf is free; NaN, 0 and less are unknown."""


@lru_cache(maxsize=8)
def fan_of(first_rad: float, step_rad: float, count: int) -> Fan:
    """The directions of `count` beams at equal angles; each sees half a step to either side."""
    bearings_rad = first_rad + step_rad * np.arange(count)
    low_rad, high_rad = sorted((first_rad, first_rad + step_rad * (count - 1)))
    half_rad = 0.5 * abs(step_rad)
    cos, sin = np.cos(bearings_rad), np.sin(bearings_rad)
    return Fan(cos, sin, low_rad - half_rad, high_rad + half_rad)
