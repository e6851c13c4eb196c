"""Cells smoothed by a cellular automaton, as data."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from reflexarc_sim_bridge.worlds.checks import Span, require_within
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.layer_kind import WHITE, MostNear, require_colour
from reflexarc_sim_bridge.worlds.layer_motion import Motion


class AutomatonColumns(NamedTuple):
    """Columns of the table of layers that an automaton fills."""

    cells: int
    """Cells along the side of a chunk."""
    fill: float
    smoothings: int


@dataclass(frozen=True)
class Automaton:
    """Cells filled at random, then smoothed as a cellular automaton, as in the BARN worlds.

    A smoothing fills a cell with five or more of its eight neighbours full, empties one with three
    or fewer, and leaves the others (Perille et al., "Benchmarking Metric Ground Navigation", 2020).
    """

    COLUMNS: ClassVar[type[AutomatonColumns]] = AutomatonColumns

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
        require_colour("automaton.colour", self.colour)

    @property
    def reach_m(self) -> float:
        """A bound for a run of cells, which ends at the border of its chunk at the latest."""
        return CHUNK_M

    def columns(self, across: Across) -> AutomatonColumns:
        """See `LayerKind`."""
        return AutomatonColumns(self.cells_per_chunk, self.fill, self.smoothings)

    def most_near(self, around: Around) -> MostNear:
        """See `LayerKind`: every other cell at most begins a run of full ones, which is one box."""
        most_runs = self.cells_per_chunk * (self.cells_per_chunk + 1) // 2
        return MostNear(boxes=around.chunks * most_runs)
