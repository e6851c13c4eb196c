"""Vectors in an agent's own frame, one for each agent: what it is drawn to, or pushed from.

x ahead, y to the left. Sums run along the rays of one agent, so its bits do not depend on how many
agents decide with it.

What a heading means here: a body that sidesteps keeps facing ahead and chooses among three
directions of motion, a body that turns chooses among three rates. For both, the direction of the
wish is the angle by which the motion is wrong, and T is that angle, positive to the left: within
the dead band the body stays on its way. A wish straight back is one to the left.
"""

from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.baseline import Floats

_STRAIGHT = np.float32(1e-4)
"""A direction nearer than this (rad) to straight ahead or straight back is that: else rounding
would say on which side of straight back a wish lies."""


@dataclass(frozen=True)
class Vectors:
    """One vector for each agent: (n,) each."""

    ahead: Floats
    left: Floats

    def __add__(self, other: "Vectors") -> "Vectors":
        return Vectors(self.ahead + other.ahead, self.left + other.left)

    def times(self, factor: Floats | float) -> "Vectors":
        """Each vector times its factor, or all times one."""
        ahead, left = (np.multiply(p, factor, dtype=np.float32) for p in (self.ahead, self.left))
        return Vectors(ahead, left)

    @property
    def lengths(self) -> Floats:
        """(n,)."""
        return np.hypot(self.ahead, self.left)

    @property
    def headings_rad(self) -> Floats:
        """Their directions, in (−π, π], to the left positive; 0 where the vector is zero: (n,)."""
        is_straight = np.abs(self.left) <= _STRAIGHT * np.abs(self.ahead)
        left = np.where(is_straight, np.float32(0.0), self.left)
        headings: Floats = np.arctan2(left, self.ahead)
        return headings


def pulled(strengths: Floats, bearings_rad: Floats) -> Vectors:
    """The sum of pulls along the rays; negative strengths push.

    Args:
        strengths: (n, rays).
        bearings_rad: of the rays, to the left positive: (rays,).
    """
    ahead = (strengths * np.cos(bearings_rad)).sum(axis=1, dtype=np.float32)
    return Vectors(ahead, (strengths * np.sin(bearings_rad)).sum(axis=1, dtype=np.float32))


def pointing(headings_rad: Floats) -> Vectors:
    """Vectors of length 1 in these directions."""
    return Vectors(np.cos(headings_rad), np.sin(headings_rad))
