"""What a world is made of, and the worlds that have a name.

Frame: x ahead, y to the left, metres. A world is endless along x. Its obstacles are a Poisson
field: `density_per_m2` centres a square metre, independent sizes, overlap allowed. An agent that
never steers meets 2ρR of them a metre, R being half the mean lateral width (the agent is a
point), so every world says what a blind agent must score.

Source of `legacy`: the paper "Reactive Vision-Based Navigation Controller for Autonomous Mobile
Agents", sections 4.1, 4.2 and 5.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType
from typing import TypeAlias

from reflexarc_runtime.errors import WorldError

Span: TypeAlias = tuple[float, float]
"""Bounds of a uniform distribution, lowest first."""

_MAX_SIZE_M = 10.0
_MAX_COVER = 0.8
_MAX_PER_METRE = 200.0


class Edges(StrEnum):
    """What lies at the sides of a world."""

    PERIODIC = "periodic"
    """Leaving at one side is entering at the other; cover is the same everywhere."""
    OPEN = "open"
    """The paper's: sideways motion ends at 0 and at the width, nothing is seen there, and
    obstacles are placed whole between the two, so that the edges are thinly covered."""


@dataclass(frozen=True)
class Rectangles:
    """Axis-aligned rectangles, both sides drawn uniformly and independently."""

    width_m: Span = (0.3, 1.5)
    """Side across the corridor (along y)."""
    length_m: Span = (0.3, 1.2)
    """Side along the corridor (along x)."""
    share: float = 1.0
    """Weight of this kind among a world's shapes."""

    def __post_init__(self) -> None:
        _require_size("rectangles.width_m", self.width_m)
        _require_size("rectangles.length_m", self.length_m)
        _require_share("rectangles.share", self.share)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent."""
        return sum(self.width_m) / 2

    @property
    def mean_area_m2(self) -> float:
        """Mean area: the sides are independent."""
        return self.mean_width_m * sum(self.length_m) / 2

    @property
    def longest_m(self) -> float:
        """The longest side that can be drawn."""
        return max(self.width_m[1], self.length_m[1])


@dataclass(frozen=True)
class Discs:
    """Discs with a uniform radius."""

    radius_m: Span = (0.15, 0.75)
    """Radius."""
    share: float = 1.0
    """Weight of this kind among a world's shapes."""

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
        low_m, high_m = self.radius_m
        return math.pi * (low_m**2 + low_m * high_m + high_m**2) / 3

    @property
    def longest_m(self) -> float:
        """The largest diameter that can be drawn."""
        return 2 * self.radius_m[1]


Shape: TypeAlias = Rectangles | Discs


@dataclass(frozen=True)
class Scanner:
    """A planar range scanner: beams at equal angles, the outermost ones at ±half of the sweep."""

    beams: int = 181
    """Beams of one sweep, 2 or more."""
    sweep_rad: float = math.pi
    """Angle from the first beam to the last, in (0, 2π)."""

    def __post_init__(self) -> None:
        _require(2 <= self.beams <= 100_000, "scanner.beams", "2 to 100000", self.beams)
        fits = 0.0 < self.sweep_rad < 2 * math.pi
        _require(fits, "scanner.sweep_rad", "in (0, 2π)", self.sweep_rad)

    @property
    def start_rad(self) -> float:
        """Bearing of the first, rightmost beam."""
        return -self.sweep_rad / 2

    @property
    def step_rad(self) -> float:
        """Angle from one beam to the next."""
        return self.sweep_rad / (self.beams - 1)


@dataclass(frozen=True)
class World:
    """An endless field of obstacles. With a seed it is one world, to the bit."""

    name: str
    width_m: float = 20.0
    """Lateral period, or width of the corridor."""
    edges: Edges = Edges.PERIODIC
    density_per_m2: float = 0.40
    """Obstacle centres a square metre."""
    shapes: tuple[Shape, ...] = field(default_factory=lambda: (Rectangles(),))
    """Rectangles, discs, or both; each takes its share."""
    colour: Span = (1.0, 1.0)
    """Grey value of an obstacle, between 0 (as the background) and 1."""
    dt_s: float = 0.1
    """Duration of a step."""
    scanner: Scanner | None = None
    """Agents see through this scanner, each ray the beam nearest to it; None: along their rays."""
    stream: int = 0
    """Worlds of one seed and different streams share no random number."""

    def __post_init__(self) -> None:
        _require(1.0 <= self.width_m <= 1e4, "width_m", "1 to 10000 m", self.width_m)
        density = self.density_per_m2
        _require(0.0 <= density < math.inf, "density_per_m2", "0 or more", density)
        crowded = f"at most {_MAX_PER_METRE:g} obstacles a metre of the whole width"
        per_metre = density * self.width_m
        _require(per_metre <= _MAX_PER_METRE, "density_per_m2", crowded, per_metre)
        kinds = [type(shape).__name__ for shape in self.shapes]
        once = 0 < len(kinds) == len(set(kinds))
        _require(once, "shapes", "Rectangles, Discs or one of each", kinds)
        _require(any(shape.share > 0.0 for shape in self.shapes), "shapes", "a share", "all 0")
        _require(0.0 < self.dt_s <= 10.0, "dt_s", "in (0, 10] s", self.dt_s)
        _require(0 <= self.stream < 1 << 32, "stream", "0 to 2³² − 1", self.stream)
        _require_span("colour", self.colour, 0.0, 1.0)
        _require(self.cover <= _MAX_COVER, "density_per_m2", f"cover ≤ {_MAX_COVER}", self.cover)
        fits = self.edges is Edges.PERIODIC or self.longest_m <= self.width_m
        _require(fits, "shapes", f"sizes up to the width, {self.width_m} m", self.longest_m)

    @property
    def mean_width_m(self) -> float:
        """Mean lateral extent of an obstacle, 2R."""
        return self._mean([shape.mean_width_m for shape in self.shapes])

    @property
    def longest_m(self) -> float:
        """The longest side that an obstacle can have."""
        return max(shape.longest_m for shape in self.shapes)

    @property
    def cover(self) -> float:
        """Share of the plane that obstacles cover, 1 − exp(−ρ E[area])."""
        mean_area_m2 = self._mean([shape.mean_area_m2 for shape in self.shapes])
        return 1.0 - math.exp(-self.density_per_m2 * mean_area_m2)

    @property
    def blind_contacts_per_100m(self) -> float:
        """What an agent that never steers scores: 100 · 2ρR (Poisson field, mean free path).

        Exact for rectangles. Beside the disc just met, its wider part still lies ahead, and a
        new place there meets it again: on discs 20 m wide a blind agent scores 3.4 % more.
        """
        return 100.0 * self.density_per_m2 * self.mean_width_m

    def _mean(self, values: list[float]) -> float:
        shares = [shape.share for shape in self.shapes]
        return math.fsum(s * v for s, v in zip(shares, values, strict=True)) / math.fsum(shares)


def world_named(name: str) -> World:
    """The world of that name.

    Raises:
        WorldError: no such world.
    """
    if name not in WORLDS:
        raise WorldError(f"world: no world is named {name!r}; known: {', '.join(WORLDS)}")
    return WORLDS[name]


def _require_size(where: str, span: Span) -> None:
    _require_span(where, span, 0.0, _MAX_SIZE_M)
    _require(span[0] > 0.0, where, "above 0 m", span)


def _require_share(where: str, share: float) -> None:
    _require(0.0 <= share < math.inf, where, "0 or more", share)


def _require_span(where: str, span: Span, least: float, most: float) -> None:
    holds = len(span) == 2 and least <= span[0] <= span[1] <= most
    _require(holds, where, f"(low, high) within {least:g} to {most:g}", span)


def _require(holds: bool, where: str, expected: str, got: object) -> None:
    if not holds:
        raise WorldError(f"world.{where}: expected {expected}, got {got}")


# "scanned" is "reference-1" seen as the lidars of the CARMEN logs see: 181 beams over 180°.
#
# Any change to "reference-1" makes a "reference-2": figures of different versions are never
# compared. The discs have the same mean width and density, so a blind agent scores the same.
#
# The paper says of its own world only: endless, corridor-like, a PyGame window, a one-pixel agent,
# rectangles placed at random, fewest of them near the edges. Ours takes the short side of a
# 640 × 480 window as the corridor, 40 pixels to the metre (a step of 0.1 m is then 4 pixels), and
# squares-to-bars of 20 to 60 pixels a side that cover a quarter of it.
WORLDS: Mapping[str, World] = MappingProxyType(
    {
        world.name: world
        for world in (
            World("reference-1"),
            World("discs", shapes=(Discs(),)),
            World("scanned", scanner=Scanner()),
            World("mixed", shapes=(Rectangles(share=0.5), Discs(share=0.5))),
            World(
                "legacy",
                width_m=12.0,
                edges=Edges.OPEN,
                density_per_m2=0.30,
                shapes=(Rectangles(width_m=(0.5, 1.5), length_m=(0.5, 1.5)),),
            ),
        )
    }
)
