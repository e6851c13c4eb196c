"""Walls across the way with openings in them, as data."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require, require_span, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import WHITE, MostNear, require_colour
from reflexarc_sim_bridge.worlds.layer_motion import Motion

PIECES = 4
"""Most pieces of a wall in a chunk: beside an opening two, of two pitches."""


class GatesColumns(NamedTuple):
    """Columns of the table of layers that gates fill."""

    spacing_chunks: int
    """Distance from wall to wall, in chunks."""
    pitch_m: float
    opening_low_m: float
    opening_high_m: float
    half_thickness_m: float


@dataclass(frozen=True)
class Gates:
    """Walls across the way, one every `spacing_m`, with an opening in every `pitch_m`."""

    COLUMNS: ClassVar[type[GatesColumns]] = GatesColumns

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
        require_colour("gates.colour", self.colour)

    @property
    def reach_m(self) -> float:
        """A bound for a piece of a wall, which ends at the border of its chunk at the latest."""
        return CHUNK_M

    def fitted_pitch_m(self, period_m: float | None) -> float:
        """Lateral distance of the openings, so that it divides a period; None: there is none."""
        if period_m is None:
            return self.pitch_m
        return period_m / max(1, round(period_m / self.pitch_m))

    def columns(self, across: Across) -> GatesColumns:
        """See `LayerKind`."""
        return GatesColumns(
            spacing_chunks=max(1, round(self.spacing_m / CHUNK_M)),
            pitch_m=self.fitted_pitch_m(across.period_m),
            opening_low_m=self.opening_m[0],
            opening_high_m=self.opening_m[1],
            half_thickness_m=self.thickness_m / 2,
        )

    def most_near(self, around: Around) -> MostNear:
        """See `LayerKind`."""
        return MostNear(boxes=PIECES * around.chunks)
