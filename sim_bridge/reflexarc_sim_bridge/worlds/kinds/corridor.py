"""Two walls that the agent drives between, as data."""

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import WHITE, MostNear, require_colour

WALLS, WALL_SIDES = 2, 4


class CorridorColumns(NamedTuple):
    """Columns of the table of layers that a corridor fills."""

    half_width_m: float
    meander_m: float
    knot_m: float
    """Distance along x of the knots through which its middle goes."""


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
    """See `Scatter.colour`; all walls of a world have one colour."""

    def __post_init__(self) -> None:
        require_within("corridor.width_m", self.width_m, 0.5, 1e3)
        require_within("corridor.meander_m", self.meander_m, 0.0, 1e3)
        require_within("corridor.wavelength_m", self.wavelength_m, 2 * CHUNK_M, 1e5)
        steepest = self.meander_m / self.wavelength_m
        require(steepest <= 0.5, "corridor.meander_m", "≤ half the wavelength", self.meander_m)
        require_colour("corridor.colour", self.colour)

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
        )

    def most_near(self, around: Around) -> MostNear:
        """See `LayerKind`."""
        return MostNear(sides=WALLS * WALL_SIDES * around.columns)
