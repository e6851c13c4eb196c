"""The shapes of obstacles: rectangles, discs, polygons and closed curves, of drawn sizes.

A shape's lateral extent is what an agent that drives straight ahead can run into; its mean over a
field, 2R, says how often a blind agent does.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.checks import Span, require, require_span, require_within
from reflexarc_sim_bridge.worlds.outlines import (
    CURVE_CORNERS,
    MAX_CORNERS,
    curve_share,
    polygon_angle_rad,
    polygon_share,
)

MAX_SIZE_M = 10.0
LOBES = (2, 5)
"""Fewest and most lobes of a curve."""

_SAMPLES = 2000
_SAMPLE_SEED = 1


@dataclass(frozen=True)
class Rectangles:
    """Rectangles, both sides drawn uniformly and independently."""

    width_m: Span = (0.3, 1.5)
    """Side across the way (along y), before it is turned."""
    length_m: Span = (0.3, 1.2)
    """Side along the way (along x), before it is turned."""
    turned_rad: Span = (0.0, 0.0)
    """Angle by which each is turned, counter-clockwise."""
    share: float = 1.0
    """Weight of this kind among a layer's shapes."""

    def __post_init__(self) -> None:
        _require_size("rectangles.width_m", self.width_m)
        _require_size("rectangles.length_m", self.length_m)
        require_span("rectangles.turned_rad", self.turned_rad, -math.tau, math.tau)
        _require_share("rectangles.share", self.share)

    @property
    def is_turned(self) -> bool:
        """Whether any of them may be turned out of the axes of the world."""
        return self.turned_rad != (0.0, 0.0)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent, E|w cos θ| + E|l sin θ|: sides and angle are independent."""
        angles = np.linspace(*self.turned_rad, 4001)
        width_m, length_m = sum(self.width_m) / 2, sum(self.length_m) / 2
        extents_m = width_m * np.abs(np.cos(angles)) + length_m * np.abs(np.sin(angles))
        return float(np.trapezoid(extents_m)) / (len(angles) - 1)

    @property
    def mean_area_m2(self) -> float:
        """Mean area: the sides are independent."""
        return sum(self.width_m) * sum(self.length_m) / 4

    @property
    def reach_m(self) -> float:
        """No such shape reaches farther from its centre, along x or y."""
        if self.is_turned:
            return math.hypot(self.width_m[1], self.length_m[1]) / 2
        return max(self.width_m[1], self.length_m[1]) / 2


@dataclass(frozen=True)
class Discs:
    """Discs with a uniform radius."""

    radius_m: Span = (0.15, 0.75)
    """Radius."""
    share: float = 1.0
    """Weight of this kind among a layer's shapes."""

    def __post_init__(self) -> None:
        _require_size("discs.radius_m", self.radius_m)
        _require_share("discs.share", self.share)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent."""
        return sum(self.radius_m)

    @property
    def mean_area_m2(self) -> float:
        """Mean area, π E[r²]."""
        return math.pi * _mean_square_m2(self.radius_m)

    @property
    def reach_m(self) -> float:
        """No disc reaches farther from its centre."""
        return self.radius_m[1]


@dataclass(frozen=True)
class Polygons:
    """Polygons with corners on a circle, turned at random; stars where they are dented."""

    radius_m: Span = (0.2, 0.9)
    """Radius of the circle around it."""
    corners: tuple[int, int] = (3, 8)
    """Fewest and most corners."""
    dent: Span = (0.0, 0.0)
    """Share of the radius by which every other corner is pulled in: above 0 it is concave."""
    share: float = 1.0
    """Weight of this kind among a layer's shapes."""

    def __post_init__(self) -> None:
        _require_size("polygons.radius_m", self.radius_m)
        require_span("polygons.corners", self.corners, 3, MAX_CORNERS)
        require_span("polygons.dent", self.dent, 0.0, 0.9)
        _require_share("polygons.share", self.share)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent, over a fixed sample of polygons."""
        return sum(self.radius_m) / 2 * _of_unit(replace(self, radius_m=(1.0, 1.0), share=1.0))[0]

    @property
    def mean_area_m2(self) -> float:
        """Mean area, over the same sample."""
        unit = replace(self, radius_m=(1.0, 1.0), share=1.0)
        return _mean_square_m2(self.radius_m) * _of_unit(unit)[1]

    @property
    def reach_m(self) -> float:
        """No polygon reaches farther from its centre."""
        return self.radius_m[1]

    def samples(self, generator: np.random.Generator) -> Iterator[npt.NDArray[np.float64]]:
        """Corners of polygons about the origin, each (corners, 2)."""
        while True:
            corners = int(generator.integers(self.corners[0], self.corners[1] + 1))
            radius_m, dent = generator.uniform(*self.radius_m), generator.uniform(*self.dent)
            turned_rad, jitters = generator.uniform(0.0, math.tau), generator.random(corners)
            yield _corners(
                [polygon_angle_rad(k, corners, jitters[k]) for k in range(corners)],
                [radius_m * polygon_share(k, dent) for k in range(corners)],
                turned_rad,
            )


@dataclass(frozen=True)
class Curves:
    """Closed smooth curves with two to five lobes, turned at random."""

    radius_m: Span = (0.2, 0.9)
    """Radius of the circle around it."""
    waviness: Span = (0.0, 0.4)
    """How deep the hollows are: 0 is a circle."""
    share: float = 1.0
    """Weight of this kind among a layer's shapes."""

    def __post_init__(self) -> None:
        _require_size("curves.radius_m", self.radius_m)
        require_span("curves.waviness", self.waviness, 0.0, 0.9)
        _require_share("curves.share", self.share)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent, over a fixed sample of curves."""
        return sum(self.radius_m) / 2 * _of_unit(replace(self, radius_m=(1.0, 1.0), share=1.0))[0]

    @property
    def mean_area_m2(self) -> float:
        """Mean area, over the same sample."""
        unit = replace(self, radius_m=(1.0, 1.0), share=1.0)
        return _mean_square_m2(self.radius_m) * _of_unit(unit)[1]

    @property
    def reach_m(self) -> float:
        """No curve reaches farther from its centre."""
        return self.radius_m[1]

    def samples(self, generator: np.random.Generator) -> Iterator[npt.NDArray[np.float64]]:
        """Corners of curves about the origin, each (corners, 2)."""
        angles = [math.tau * k / CURVE_CORNERS for k in range(CURVE_CORNERS)]
        while True:
            lobes = int(generator.integers(LOBES[0], LOBES[1] + 1))
            radius_m, waviness = (
                generator.uniform(*self.radius_m),
                generator.uniform(*self.waviness),
            )
            turned_rad = generator.uniform(0.0, math.tau)
            radii_m = [radius_m * curve_share(angle, lobes, waviness) for angle in angles]
            yield _corners(angles, radii_m, turned_rad)


Shape: TypeAlias = Rectangles | Discs | Polygons | Curves


@lru_cache(maxsize=256)
def _of_unit(shape: Polygons | Curves) -> tuple[float, float]:
    """Mean lateral extent (m) and mean area (m²) of a shape of radius 1 m, to about half a percent.

    The radius is independent of the outline: one sample serves all radii.
    """
    samples = shape.samples(np.random.default_rng(_SAMPLE_SEED))
    outlines = [next(samples) for _ in range(_SAMPLES)]
    widths_m = [float(np.ptp(outline[:, 1])) for outline in outlines]
    return math.fsum(widths_m) / _SAMPLES, math.fsum(map(_area_m2, outlines)) / _SAMPLES


def _mean_square_m2(span_m: Span) -> float:
    low_m, high_m = span_m
    return (low_m**2 + low_m * high_m + high_m**2) / 3


def _corners(
    angles_rad: list[float], radii_m: list[float], turned_rad: float
) -> npt.NDArray[np.float64]:
    angles = np.array(angles_rad) + turned_rad
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners_m: npt.NDArray[np.float64] = directions * np.array(radii_m)[:, np.newaxis]
    return corners_m


def _area_m2(outline: npt.NDArray[np.float64]) -> float:
    """Gauss's shoelace formula."""
    (x, y), (next_x, next_y) = outline.T, np.roll(outline, -1, axis=0).T
    return float(np.abs(x @ next_y - y @ next_x)) / 2


def _require_size(where: str, span: Span) -> None:
    require_span(where, span, 0.0, MAX_SIZE_M)
    require(span[0] > 0.0, where, "above 0 m", span)


def _require_share(where: str, share: float) -> None:
    require_within(where, share, 0.0, 1e6)
