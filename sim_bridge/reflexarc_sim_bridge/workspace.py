"""Scratch of one thread: nothing in it outlives the look or the step that filled it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.automaton import MAX_ROWS
from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.params import Floats32, Params
from reflexarc_sim_bridge.upright_boxes import EIGHT, Entries


class Workspace(NamedTuple):
    """What an eye needs while it looks."""

    judged: npt.NDArray[np.bool_]
    """Whether a tile of rays can meet a near obstacle: (capacity,)."""
    picked: npt.NDArray[np.int64]
    """Those that it can: (capacity,)."""
    ahead: Floats32
    """Direction of each sub-ray in the world's frame: (subrays,); so the three below."""
    left: Floats32
    per_ahead: Floats32
    per_left: Floats32
    distance_m: Floats32
    """What each sub-ray met, the range where nothing: (subrays,)."""
    paint: Floats32
    """Its colour, 8 bits each of red, green, blue; below 0 where nothing: (subrays,)."""
    entries: Entries
    """For gathering upright boxes."""
    cells: npt.NDArray[np.uint64]
    """Rows of an automaton's cells: (MAX_ROWS,)."""
    retina: npt.NDArray[np.uint8]
    """Of both eyes: (values,)."""


@compiled_allocating
def new_workspace(params: Params) -> Workspace:
    """The scratch that a thread needs for these worlds, eyes and agents."""
    world, agents, rays = params.world, params.agents, params.eye.ahead.size
    columns = max(agents.boxes.shape[3], agents.discs.shape[3], agents.sides.shape[3])
    return Workspace(
        np.empty(columns, np.bool_),
        np.empty(columns, np.int64),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        _new_entries(world.most_chunks, world.most_chunks * world.counts.shape[3] + EIGHT),
        np.empty(MAX_ROWS, np.uint64),
        np.empty(agents.delayed.shape[2], np.uint8),
    )


@compiled_allocating
def _new_entries(chunks: int, entries: int) -> Entries:
    return Entries(
        np.empty(chunks, np.uint64),
        np.empty(chunks, np.float64),
        np.empty(chunks, np.float64),
        np.empty(chunks, np.float64),
        np.empty(chunks, np.int64),
        np.empty(entries, np.uint64),
        np.empty(entries, np.float32),
        np.empty(entries, np.float32),
        np.empty(entries, np.float32),
        np.empty(entries, np.float32),
        np.empty(entries, np.bool_),
    )
