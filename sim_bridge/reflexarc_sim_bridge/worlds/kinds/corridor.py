"""Two walls that the agent drives between, as data."""

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import (
    WHITE,
    MostNear,
    require_colour,
    require_stripes,
)

WALLS, WALL_SIDES = 2, 4


class CorridorColumns(NamedTuple):
    """Columns of the table of layers that a corridor fills."""

    half_width_m: float
    meander_m: float
    knot_m: float
    """Distance along x of the knots through which its middle goes."""
    stripes_m: float
    right_wall_mps: float
    left_wall_mps: float
    right_contrast: float
    left_contrast: float


@dataclass(frozen=True)
class Corridor:
    """Two walls that meander; they are seen, and touching one is a contact."""

    COLUMNS: ClassVar[type[CorridorColumns]] = CorridorColumns

    width_m: float = 9.0
    """From wall to wall."""
    meander_m: float = 3.0
    """How far its middle strays to each side."""
    wavelength_m: float = 40.0
    """Length over which it strays."""
    colour: tuple[Span, ...] = WHITE
    """See `Scatter.colour`; both walls have one colour, unless they are striped."""
    stripes_m: float = 0.0
    """Length along x of a stripe, each of a shade of its own within `colour`; 0: no stripes."""
    left_wall_mps: float = 0.0
    """Speed ahead of the left wall's stripes; the wall itself stays."""
    right_wall_mps: float = 0.0
    """The same of the right wall."""
    left_contrast: float = 1.0
    """How far the shades of the left wall's stripes lie from the middle of `colour`: 0 to 1."""
    right_contrast: float = 1.0
    """The same of the right wall."""

    def __post_init__(self) -> None:
        require_within("corridor.width_m", self.width_m, 0.5, 1e3)
        require_within("corridor.meander_m", self.meander_m, 0.0, 1e3)
        require_within("corridor.wavelength_m", self.wavelength_m, 2 * CHUNK_M, 1e5)
        steepest = self.meander_m / self.wavelength_m
        require(steepest <= 0.5, "corridor.meander_m", "≤ half the wavelength", self.meander_m)
        require_colour("corridor.colour", self.colour)
        require_stripes("corridor", self.stripes_m, self.colour)
        self._check_speed("left_wall_mps", self.left_wall_mps)
        self._check_speed("right_wall_mps", self.right_wall_mps)
        self._check_contrast("left_contrast", self.left_contrast)
        self._check_contrast("right_contrast", self.right_contrast)

    @property
    def motion(self) -> None:
        """Walls stand still."""
        return

    @property
    def reach_m(self) -> float:
        """A bound for a piece of a wall, which is as long as a chunk, where it is steepest."""
        steepest = math.pi * self.meander_m / (self.wavelength_m / 2)
        return CHUNK_M * max(1.0, 0.5 + 0.5 * steepest)

    def columns(self, across: Across) -> CorridorColumns:
        """See `LayerKind`."""
        return CorridorColumns(
            half_width_m=self.width_m / 2,
            meander_m=self.meander_m,
            knot_m=self.wavelength_m / 2,
            stripes_m=self.stripes_m,
            right_wall_mps=self.right_wall_mps,
            left_wall_mps=self.left_wall_mps,
            right_contrast=self.right_contrast,
            left_contrast=self.left_contrast,
        )

    def most_near(self, around: Around) -> MostNear:
        """See `LayerKind`."""
        return MostNear(sides=WALLS * WALL_SIDES * around.columns)

    def _check_speed(self, name: str, speed_mps: float) -> None:
        require_within(f"corridor.{name}", speed_mps, -100.0, 100.0)
        shows = speed_mps == 0.0 or self.stripes_m > 0.0
        require(shows, f"corridor.{name}", "0 without `stripes_m`: nothing would move", speed_mps)

    def _check_contrast(self, name: str, contrast: float) -> None:
        require_within(f"corridor.{name}", contrast, 0.0, 1.0)
        shows = contrast == 1.0 or self.stripes_m > 0.0
        require(shows, f"corridor.{name}", "1 without `stripes_m`: nothing would differ", contrast)
