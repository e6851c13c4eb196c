"""The grid that a layer is drawn on: chunks, each with obstacles of its own."""

import math
from typing import NamedTuple

CHUNK_M = 2.5
"""Side of a chunk; across a periodic world the nearest length that divides its width."""


class Across(NamedTuple):
    """What lies across a world, along y."""

    chunk_width_m: float
    """Side of a chunk along y."""
    period_m: float | None
    """Width after which the world repeats; None: it does not."""


class Around(NamedTuple):
    """The part of a layer that may be near an agent: all that reaches into the agent's box."""

    length_m: float
    """Its side along x."""
    width_m: float
    """Its side along y."""
    chunk_width_m: float
    """Side of a chunk along y."""
    crowding: float
    """How much denser obstacles lie than they are drawn; above 1 between open sides only."""

    @property
    def columns(self) -> int:
        """Most chunks side by side along x."""
        return math.ceil(self.length_m / CHUNK_M + 1)

    @property
    def chunks(self) -> int:
        """Most chunks in all."""
        return self.columns * math.ceil(self.width_m / self.chunk_width_m + 1)


def chunks_across(width_m: float) -> int:
    """How many chunks lie side by side in a world that has sides."""
    return max(1, round(width_m / CHUNK_M))


def telling_widths_m(low_m: float, high_m: float) -> tuple[float, ...]:
    """Widths of a range at which a world may need most memory.

    These are the ends of the range, and the widths with the widest and the narrowest chunks. Chunks
    are widest just before another one fits, the more so the fewer they are.
    """
    fewest = max(1, math.ceil(low_m / CHUNK_M - 0.5))
    turns_m = [(chunks + 0.5) * CHUNK_M for chunks in (fewest, fewest + 1)]
    around = [(math.nextafter(t, 0.0), t, math.nextafter(t, math.inf)) for t in turns_m]
    within = [width_m for widths_m in around for width_m in widths_m if low_m < width_m < high_m]
    return tuple(sorted({low_m, *within, high_m}))
