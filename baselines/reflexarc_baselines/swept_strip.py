"""How far a body that goes along a path is free: the strip that it sweeps, and what rays met in it.

Points are where rays ended, x ahead and y to the left of the body, which starts at the origin.
A path has two legs: one along a heading, then one straight ahead.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.baseline import Floats


@dataclass(frozen=True)
class Path:
    """A way in two legs."""

    heading_rad: float
    """Of the first leg, to the left positive; the second leads straight ahead."""
    first_leg_m: float
    """Length of the first leg."""
    half_width_m: float
    """Half the width of the strip."""

    @property
    def corner_m(self) -> tuple[float, float]:
        """Where the second leg begins."""
        ahead_m = self.first_leg_m * math.cos(self.heading_rad)
        return ahead_m, self.first_leg_m * math.sin(self.heading_rad)


def free_on_legs_m(x_m: Floats, y_m: Floats, path: Path, most_m: float) -> tuple[Floats, Floats]:
    """How far each leg of a path is free, as if the other were: (n,) and (n,).

    The first leg's length, or `most_m` for the second, where it meets nothing.

    Args:
        x_m: of the points: (n, rays); inf where a ray met nothing.
        y_m: the same.
        path: where the body would go.
        most_m: how far the second leg is looked along.
    """
    cos, sin = np.float32(math.cos(path.heading_rad)), np.float32(math.sin(path.heading_rad))
    corner_x_m, corner_y_m = map(np.float32, path.corner_m)
    first_m = _first_in(x_m * cos + y_m * sin, y_m * cos - x_m * sin, path.half_width_m)
    second_m = _first_in(x_m - corner_x_m, y_m - corner_y_m, path.half_width_m)
    return np.minimum(first_m, np.float32(path.first_leg_m)), np.minimum(
        second_m, np.float32(most_m)
    )


def _first_in(along_m: Floats, aside_m: Floats, half_width_m: float) -> Floats:
    """The nearest point in a strip that begins at 0; inf if there is none."""
    is_in = (np.abs(aside_m) < np.float32(half_width_m)) & (along_m >= 0.0)
    nearest: Floats = np.where(is_in, along_m, np.float32(np.inf)).min(axis=1)
    return nearest
