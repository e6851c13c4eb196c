"""Striped obstacles cut into their stripes, as seen from above, for drawing.

A wall is cut across. A rectangle or a disc is cut into pieces like a pie, from its middle to where
stripes and sides meet: its outline has the shades that an eye sees there.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import Row
from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.obstacles.keys import layer_key
from reflexarc_sim_bridge.obstacles.stripes import contrast_of_wall, place_on_wall_m, stripe_at

_SLICES = 36
"""A disc is drawn with so many corners, and those of its stripes."""


@dataclass(frozen=True)
class Stripe:
    """A piece of an obstacle that has one shade."""

    corners_m: npt.NDArray[np.float64]
    """Counter-clockwise: (corners, 2)."""
    colour: tuple[float, float, float]
    """Red, green, blue, 0 to 1."""


@dataclass(frozen=True)
class Striping:
    """The stripes of a layer at one time."""

    layer: Row
    """Its row of the table of layers."""
    number: int
    """Which layer."""
    stream: int
    """The world's."""
    seed: int
    time_s: float

    @property
    def middle_colour(self) -> tuple[float, float, float]:
        """The middle of what the stripes' colours are drawn from."""
        red, green, blue = (
            float(self.layer[f"{name}_low"] + self.layer[f"{name}_high"]) / 2
            for name in ("red", "green", "blue")
        )
        return red, green, blue

    def of_wall(self, corners_m: npt.NDArray[np.float64], wall: int) -> tuple[Stripe, ...]:
        """Stripes of a piece of the right (0) or left (1) wall, whose ends lie along y: (4, 2)."""
        rear_right, rear_left, front_right, front_left = corners_m[np.lexsort(corners_m.T[::-1])]
        low_m, high_m = float(rear_right[0]), float(front_right[0])
        contrast = _contrast_of_wall(self.layer, wall)
        ahead_m = -_place_on_wall_m(self.layer, wall, 0.0, self.time_s)
        found = []
        for from_m, to_m in self._cut(low_m - ahead_m, high_m - ahead_m):
            rear, front = ((m + ahead_m - low_m) / (high_m - low_m) for m in (from_m, to_m))
            rights = [rear_right + (front_right - rear_right) * share for share in (rear, front)]
            lefts = [rear_left + (front_left - rear_left) * share for share in (front, rear)]
            found.append(self._stripe([*rights, *lefts], wall, (from_m + to_m) / 2, contrast))
        return tuple(found)

    def of_box(self, corners_m: npt.NDArray[np.float64], surface: int) -> tuple[Stripe, ...]:
        """Stripes of a rectangle, its front left corner first: (4, 2)."""
        middle_m, begin_m, found = corners_m.mean(axis=0), 0.0, []
        for here, there in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True):
            length_m = math.dist(here, there)
            for from_m, to_m in self._cut(begin_m, begin_m + length_m):
                ends = [here + (there - here) * ((m - begin_m) / length_m) for m in (from_m, to_m)]
                found.append(self._stripe([middle_m, *ends], surface, (from_m + to_m) / 2))
            begin_m += length_m
        return tuple(found)

    def of_disc(self, x_m: float, y_m: float, radius_m: float, surface: int) -> tuple[Stripe, ...]:
        """Stripes of a disc."""
        middle_m, slice_m, found = np.array([x_m, y_m]), math.tau * radius_m / _SLICES, []
        for piece in range(_SLICES):
            for ends_m in self._cut(piece * slice_m, (piece + 1) * slice_m):
                angles = np.array(ends_m) / radius_m
                ends = middle_m + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)
                found.append(self._stripe([middle_m, *ends], surface, sum(ends_m) / 2))
        return tuple(found)

    def _cut(self, from_m: float, to_m: float) -> Iterator[tuple[float, float]]:
        """Cut a part of a surface where one stripe ends and the next begins."""
        period_m = float(self.layer["stripes_m"])
        first, last = math.floor(from_m / period_m) + 1, math.ceil(to_m / period_m)
        cuts_m = [from_m, *(k * period_m for k in range(first, last)), to_m]
        yield from itertools.pairwise(cuts_m)

    def _stripe(
        self,
        corners_m: list[npt.NDArray[np.float64]],
        surface: int,
        place_m: float,
        contrast: float = 1.0,
    ) -> Stripe:
        key = self.stream, np.uint64(self.seed), self.number
        paint = _paint_at(self.layer, *key, surface, place_m, contrast)
        return Stripe(np.array(corners_m), rgb_of(paint))


def rgb_of(paint: float) -> tuple[float, float, float]:
    """Red, green and blue, 0 to 1, of 8 bits each."""
    bits = int(paint)
    return (bits >> 16) / 255, (bits >> 8 & 255) / 255, (bits & 255) / 255


@compiled
def _paint_at(
    layer: Row,
    stream: int,
    seed: np.uint64,
    number: int,
    surface: int,
    place_m: float,
    contrast: float,
) -> int:
    return stripe_at(layer, layer_key(stream, seed, number), surface, place_m, contrast)


@compiled
def _place_on_wall_m(layer: Row, wall: int, x_m: float, time_s: float) -> float:
    return place_on_wall_m(layer, wall, x_m, time_s)


@compiled
def _contrast_of_wall(layer: Row, wall: int) -> float:
    return contrast_of_wall(layer, wall)
