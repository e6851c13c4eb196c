"""Obstacles seen from above, as a picture shows them: plain shapes, nothing compiled.

Frame: x ahead to the right of a picture, y to the left upwards, metres.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.layers import Drift, Motion

Floats: TypeAlias = npt.NDArray[np.float64]
Rgb: TypeAlias = tuple[float, float, float]
"""Red, green, blue, 0 to 1."""

SLATE: Rgb = (0.54, 0.64, 0.74)
"""Drawn in place of white, the colour of most obstacles, which would not show on pale ground."""
CIRCLE_CORNERS = 36


class Area(NamedTuple):
    """A rectangle of the plane (m)."""

    low_x_m: float
    high_x_m: float
    low_y_m: float
    high_y_m: float


@dataclass(frozen=True)
class Silhouette:
    """The outline of one obstacle, seen from above."""

    corners_m: Floats
    """(corners, 2)."""
    colour: Rgb
    wake_m: tuple[float, float] = (0.0, 0.0)
    """How far it moved within the last second: ahead, left."""


def circle(x_m: float, y_m: float, radius_m: float) -> Floats:
    """Corners of a disc: (corners, 2)."""
    angles = np.linspace(0.0, 2 * np.pi, CIRCLE_CORNERS, endpoint=False)
    return np.array([x_m, y_m]) + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def reaches_into(corners_m: Floats, area: Area) -> bool:
    """Whether the bounding box of some corners overlaps an area."""
    (low_x, low_y), (high_x, high_y) = corners_m.min(axis=0), corners_m.max(axis=0)
    beside = low_x > area.high_x_m or high_x < area.low_x_m
    return not (beside or low_y > area.high_y_m or high_y < area.low_y_m)


def on_pale_ground(colour: Rgb) -> Rgb:
    """Greys become shades of slate; other colours stay."""
    red, green, blue = colour
    if red == green == blue:
        return (red * SLATE[0], green * SLATE[1], blue * SLATE[2])
    return colour


def moved_m(motion: Motion | None, time_s: float) -> tuple[float, float]:
    """How far a layer has moved, ahead and left; the same formula as in the compiled simulator."""
    if motion is None:
        return 0.0, 0.0
    if isinstance(motion, Drift):
        return motion.ahead_mps * time_s, motion.left_mps * time_s
    share = math.sin(2.0 * math.pi * time_s / motion.period_s)
    return motion.ahead_m * share, motion.left_m * share
