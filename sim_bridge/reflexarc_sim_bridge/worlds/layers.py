"""What a world is filled with: layers of obstacles, each at rest or moving as a whole.

A layer is a grid of chunks in a frame of its own. A frame that drifts keeps one velocity for ever;
one that swings goes to and fro. So the place of every obstacle is a closed form of the time.
"""

import math
from dataclasses import dataclass, field
from typing import TypeAlias

from reflexarc_sim_bridge.worlds.checks import Span, require, require_span, require_within
from reflexarc_sim_bridge.worlds.shapes import Rectangles, Shape

CHUNK_M = 2.5
"""Side of a chunk; across a periodic world the nearest length that divides its width."""
MAX_SECTIONS = 8

WHITE: tuple[Span, ...] = ((1.0, 1.0),)

_MAX_DENSITY = 16.0
_MAX_COVER = 0.8


def chunks_across(width_m: float) -> int:
    """How many chunks lie side by side in a world that has sides."""
    return max(1, round(width_m / CHUNK_M))


def telling_widths_m(low_m: float, high_m: float) -> tuple[float, ...]:
    """Of the widths in a range the ends, and those with the widest and the narrowest chunks.

    Chunks are widest just before another one fits, the more so the fewer they are.
    """
    fewest = max(1, math.ceil(low_m / CHUNK_M - 0.5))
    turns_m = [(chunks + 0.5) * CHUNK_M for chunks in (fewest, fewest + 1)]
    around = [(math.nextafter(t, 0.0), t, math.nextafter(t, math.inf)) for t in turns_m]
    within = [width_m for widths_m in around for width_m in widths_m if low_m < width_m < high_m]
    return tuple(sorted({low_m, *within, high_m}))


@dataclass(frozen=True)
class Drift:
    """A layer that moves at one velocity, for ever."""

    ahead_mps: float = 0.0
    left_mps: float = 0.0

    def __post_init__(self) -> None:
        require_within("drift.ahead_mps", self.ahead_mps, -100.0, 100.0)
        require_within("drift.left_mps", self.left_mps, -100.0, 100.0)


@dataclass(frozen=True)
class Swing:
    """A layer that goes to and fro: displacement · sin(2π t / period)."""

    ahead_m: float = 0.0
    left_m: float = 1.0
    period_s: float = 4.0

    def __post_init__(self) -> None:
        require_within("swing.ahead_m", self.ahead_m, -100.0, 100.0)
        require_within("swing.left_m", self.left_m, -100.0, 100.0)
        require_within("swing.period_s", self.period_s, 0.1, 1e6)


Motion: TypeAlias = Drift | Swing


@dataclass(frozen=True)
class Scatter:
    """A Poisson field: centres independent of each other, overlap allowed.

    With `gap_m` it is thinned (Matérn's second rule: of two centres closer than that, the one with
    the lower mark stays). With `sections` the density changes along the way, in steps.
    """

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
        _require_colour("scatter.colour", self.colour)
        crowded = f"cover ≤ {_MAX_COVER}"
        require(self.cover <= _MAX_COVER, "scatter.density_per_m2", crowded, f"{self.cover:.2f}")

    @property
    def is_poisson(self) -> bool:
        """Unthinned and even: a blind agent must meet 2ρR of them a metre."""
        return self.gap_m == 0.0 and not self.sections and self.motion is None

    @property
    def mean_density_per_m2(self) -> float:
        """Obstacle centres a square metre over all sections, after thinning.

        Matérn's second rule keeps (1 − exp(−ρπg²)) / (πg²) of them.
        """
        densities = [self.density_per_m2 * factor for factor in self.sections or (1.0,)]
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

    def _mean(self, values: list[float]) -> float:
        shares = [shape.share for shape in self.shapes]
        return math.fsum(s * v for s, v in zip(shares, values, strict=True)) / math.fsum(shares)


@dataclass(frozen=True)
class Gates:
    """Walls across the way, one every `spacing_m`, with an opening in every `pitch_m`."""

    spacing_m: float = 10.0
    """Distance from wall to wall; rounded to whole chunks."""
    pitch_m: float = 10.0
    """Lateral distance of the openings; rounded so that it divides the width."""
    opening_m: Span = (1.0, 2.0)
    """Width of an opening; it lies anywhere within its pitch."""
    thickness_m: float = 0.3
    """Of the wall."""
    colour: tuple[Span, ...] = WHITE
    """See `Scatter.colour`; one wall has one colour."""
    motion: Motion | None = None
    """How the layer moves; None: it stands still."""

    def __post_init__(self) -> None:
        require_within("gates.spacing_m", self.spacing_m, CHUNK_M, 1e4)
        require_within("gates.pitch_m", self.pitch_m, CHUNK_M, 1e4)
        require_span("gates.opening_m", self.opening_m, 0.0, 1e4)
        fits = self.opening_m[0] > 0.0 and self.opening_m[1] < self.pitch_m
        require(fits, "gates.opening_m", "above 0, below the pitch", self.opening_m)
        require_within("gates.thickness_m", self.thickness_m, 0.01, CHUNK_M / 2)
        _require_colour("gates.colour", self.colour)

    @property
    def reach_m(self) -> float:
        """A wall is cut into pieces, one a chunk."""
        return CHUNK_M


@dataclass(frozen=True)
class Corridor:
    """Two walls that meander; they are seen, and touching one is a contact."""

    width_m: float = 9.0
    """From wall to wall."""
    meander_m: float = 3.0
    """How far its middle strays to each side."""
    wavelength_m: float = 40.0
    """Length over which it strays."""
    colour: tuple[Span, ...] = WHITE
    """See `Scatter.colour`; all walls of a world have one colour."""

    def __post_init__(self) -> None:
        require_within("corridor.width_m", self.width_m, 0.5, 1e3)
        require_within("corridor.meander_m", self.meander_m, 0.0, 1e3)
        require_within("corridor.wavelength_m", self.wavelength_m, 2 * CHUNK_M, 1e5)
        steepest = self.meander_m / self.wavelength_m
        require(steepest <= 0.5, "corridor.meander_m", "≤ half the wavelength", self.meander_m)
        _require_colour("corridor.colour", self.colour)

    @property
    def motion(self) -> None:
        """Walls stand still."""
        return

    @property
    def reach_m(self) -> float:
        """A wall is cut into pieces, one a chunk's length; nowhere is it steeper than that."""
        steepest = math.pi * self.meander_m / (self.wavelength_m / 2)
        return CHUNK_M * max(1.0, 0.5 + 0.5 * steepest)


@dataclass(frozen=True)
class Automaton:
    """Cells filled at random, then smoothed as a cellular automaton, as in the BARN worlds.

    A smoothing fills a cell with five or more of its eight neighbours full, empties one with three
    or fewer, and leaves the others (Perille et al., "Benchmarking Metric Ground Navigation", 2020).
    """

    cells_per_chunk: int = 10
    """Cells along the side of a chunk."""
    fill: float = 0.20
    """Share of the cells that are full before smoothing."""
    smoothings: int = 2
    """How often it is smoothed."""
    colour: tuple[Span, ...] = WHITE
    """See `Scatter.colour`; one row of full cells has one colour."""
    motion: Motion | None = None
    """How the layer moves; None: it stands still."""

    def __post_init__(self) -> None:
        require_within("automaton.cells_per_chunk", self.cells_per_chunk, 2, 16)
        require_within("automaton.fill", self.fill, 0.0, 0.6)
        require_within("automaton.smoothings", self.smoothings, 0, 4)
        _require_colour("automaton.colour", self.colour)

    @property
    def reach_m(self) -> float:
        """A row of cells is cut at the borders of chunks."""
        return CHUNK_M


Layer: TypeAlias = Scatter | Gates | Corridor | Automaton


def _require_colour(where: str, colour: tuple[Span, ...]) -> None:
    require(len(colour) in (1, 3), where, "one span (grey) or three (red, green, blue)", colour)
    for span in colour:
        require_span(where, span, 0.0, 1.0)
