"""A kind of layer that is not shipped, as data: rows of posts across the way."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import WHITE, MostNear, require_colour
from reflexarc_sim_bridge.worlds.layer_motion import Motion


class FenceColumns(NamedTuple):
    """Names that gates have as well: the table of layers stays as it is, and so does what is
    compiled for it."""

    spacing_chunks: int
    pitch_m: float
    half_thickness_m: float


@dataclass(frozen=True)
class Fence:
    """Posts, discs `pitch_m` apart, in the middle of every so many columns of chunks."""

    COLUMNS: ClassVar[type[FenceColumns]] = FenceColumns

    spacing_m: float = 10.0
    pitch_m: float = 2.0
    radius_m: float = 0.1
    colour: tuple[Span, ...] = WHITE
    motion: Motion | None = None

    def __post_init__(self) -> None:
        require_within("fence.spacing_m", self.spacing_m, CHUNK_M, 1e4)
        require_within("fence.pitch_m", self.pitch_m, 0.1, 1e4)
        require_within("fence.radius_m", self.radius_m, 0.01, 1.0)
        require_colour("fence.colour", self.colour)

    @property
    def reach_m(self) -> float:
        return self.radius_m

    def columns(self, across: Across) -> FenceColumns:
        return FenceColumns(round(self.spacing_m / CHUNK_M), self.pitch_m, self.radius_m)

    def most_near(self, around: Around) -> MostNear:
        return MostNear(discs=around.chunks * (1 + int(around.chunk_width_m / self.pitch_m)))
