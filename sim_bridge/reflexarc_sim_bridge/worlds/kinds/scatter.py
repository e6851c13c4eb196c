"""Obstacles scattered over the plane as data: their density, shapes and gaps."""

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import (
    WHITE,
    MostNear,
    require_colour,
    require_stripes,
)
from reflexarc_sim_bridge.worlds.layer_motion import Motion
from reflexarc_sim_bridge.worlds.outlines import CURVE_CORNERS
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles, Shape

MAX_SECTIONS = 8

_MAX_DENSITY = 16.0
_MAX_COVER = 0.8
_DEVIATIONS, _SPARE = 10, 20
"""A Poisson count is taken to be at most its mean, ten standard deviations, and twenty more."""


class ScatterColumns(NamedTuple):
    """Columns of the table of layers that a scatter fills; shapes and counts have other tables."""

    shapes: int
    """How many kinds of shapes it has."""
    is_plain: int
    """Whether it has one kind of shape, none of them turned."""
    gap_m: float
    sections: int
    """How many; 1 where the density is even."""
    section_chunks: int
    """Length of a section, in chunks."""
    stripes_m: float


@dataclass(frozen=True)
class Scatter:
    """A Poisson field: centres independent of each other, overlap allowed.

    With `gap_m` it is thinned (Matérn's second rule: of two centres closer than that, the one with
    the lower mark stays). With `sections` the density changes along the way, in steps.
    """

    COLUMNS: ClassVar[type[ScatterColumns]] = ScatterColumns

    density_per_m2: float = 0.40
    """Obstacle centres a square metre, before any thinning."""
    shapes: tuple[Shape, ...] = field(default_factory=lambda: (Rectangles(),))
    """Kinds of shapes; each takes its share."""
    gap_m: float = 0.0
    """Least distance between two centres; 0 for none."""
    sections: tuple[float, ...] = ()
    """Factors of the density, one section after the other, then from the start again."""
    section_m: float = 20.0
    """Length of a section."""
    colour: tuple[Span, ...] = WHITE
    """Of each obstacle: one span for grey, or three for red, green and blue; 0 to 1."""
    motion: Motion | None = None
    """How the layer moves; None: it stands still."""
    stripes_m: float = 0.0
    """Length along the outline of a stripe, each of a shade of its own within `colour`; 0: every
    obstacle is of one shade. Rectangles and discs only."""

    def __post_init__(self) -> None:
        require_within("scatter.density_per_m2", self.density_per_m2, 0.0, _MAX_DENSITY)
        require(len(self.shapes) > 0, "scatter.shapes", "one or more", "none")
        has_share = any(shape.share > 0.0 for shape in self.shapes)
        require(has_share, "scatter.shapes", "a share", "all 0")
        require_within("scatter.gap_m", self.gap_m, 0.0, CHUNK_M / 2)
        few = len(self.sections) <= MAX_SECTIONS
        require(few, "scatter.sections", f"at most {MAX_SECTIONS}", len(self.sections))
        for factor in self.sections:
            require_within("scatter.sections", factor, 0.0, 10.0)
        require_within("scatter.section_m", self.section_m, CHUNK_M, 1e4)
        require_colour("scatter.colour", self.colour)
        require_stripes("scatter", self.stripes_m, self.colour)
        round_or_square = all(isinstance(shape, Rectangles | Discs) for shape in self.shapes)
        fits = self.stripes_m == 0.0 or round_or_square
        require(fits, "scatter.stripes_m", "0 unless all are rectangles or discs", self.stripes_m)
        crowded = f"cover ≤ {_MAX_COVER}"
        require(self.cover <= _MAX_COVER, "scatter.density_per_m2", crowded, f"{self.cover:.2f}")

    @property
    def is_poisson(self) -> bool:
        """Unthinned and even: a blind agent must meet 2ρR of them a metre."""
        return self.gap_m == 0.0 and not self.sections and self.motion is None

    @property
    def section_densities_per_m2(self) -> tuple[float, ...]:
        """Obstacle centres a square metre of each section, before any thinning."""
        return tuple(self.density_per_m2 * factor for factor in self.sections or (1.0,))

    @property
    def mean_density_per_m2(self) -> float:
        """Obstacle centres a square metre over all sections, after thinning.

        Matérn's second rule keeps (1 − exp(−ρπg²)) / (πg²) of them.
        """
        densities: list[float] = list(self.section_densities_per_m2)
        disc_m2 = math.pi * self.gap_m**2
        if disc_m2 > 0.0:
            densities = [-math.expm1(-density * disc_m2) / disc_m2 for density in densities]
        return math.fsum(densities) / len(densities)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent of an obstacle, 2R."""
        return self._mean([shape.mean_width_m for shape in self.shapes])

    @property
    def reach_m(self) -> float:
        """No obstacle reaches farther from its centre."""
        return max(shape.reach_m for shape in self.shapes)

    @property
    def cover(self) -> float:
        """Share of the plane that obstacles cover, 1 − exp(−ρ E[area])."""
        mean_area_m2 = self._mean([shape.mean_area_m2 for shape in self.shapes])
        return -math.expm1(-self.mean_density_per_m2 * mean_area_m2)

    def columns(self, across: Across) -> ScatterColumns:
        """See `LayerKind`."""
        only = self.shapes[0]
        upright = isinstance(only, Discs) or (isinstance(only, Rectangles) and not only.is_turned)
        return ScatterColumns(
            shapes=len(self.shapes),
            is_plain=len(self.shapes) == 1 and upright,
            gap_m=self.gap_m,
            sections=max(1, len(self.sections)),
            section_chunks=max(1, round(self.section_m / CHUNK_M)),
            stripes_m=self.stripes_m,
        )

    def most_near(self, around: Around) -> MostNear:
        """See `LayerKind`."""
        density_per_m2 = max(self.section_densities_per_m2) * around.crowding
        most = most_of_poisson(density_per_m2 * around.length_m * around.width_m)
        rectangles = [shape.is_turned for shape in self.shapes if isinstance(shape, Rectangles)]
        return MostNear(
            boxes=most * (False in rectangles),
            turned=most * (True in rectangles),
            discs=most * any(isinstance(shape, Discs) for shape in self.shapes),
            sides=most * max(map(_most_corners, self.shapes)),
        )

    def _mean(self, values: list[float]) -> float:
        shares = [shape.share for shape in self.shapes]
        return math.fsum(s * v for s, v in zip(shares, values, strict=True)) / math.fsum(shares)


def most_of_poisson(mean: float) -> int:
    """A count that a Poisson variable of that mean does not reach in practice."""
    return math.ceil(mean + _DEVIATIONS * math.sqrt(mean) + _SPARE)


def _most_corners(shape: Shape) -> int:
    """Most sides of such a shape in the near list of sides; 0 if it is kept in another list."""
    match shape:
        case Polygons():
            return shape.corners[1]
        case Curves():
            return CURVE_CORNERS
    return 0
