"""Scratch of one thread: nothing in it outlives the look or the step that filled it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.aim import aim
from reflexarc_sim_bridge.automaton import MAX_ROWS
from reflexarc_sim_bridge.belt import EIGHT, Draws, Picks
from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.params import TURNED_ROWS, Floats32, Params, WorldTables
from reflexarc_sim_bridge.pick import Sieve
from reflexarc_sim_bridge.sieve import LANES

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


class Workspace(NamedTuple):
    """What an eye needs while it looks."""

    sieve: Sieve
    """For picking what a tile of rays can meet."""
    seen: Floats32
    """Those that several tiles can, from the eye, rows as in the near lists: (7, capacity)."""
    ahead: Floats32
    """Direction of each sub-ray in the world's frame: (subrays,); so the three below."""
    left: Floats32
    per_ahead: Floats32
    per_left: Floats32
    distance_m: Floats32
    """What each sub-ray met, the range where nothing: (subrays,)."""
    paint: Floats32
    """Its colour, 8 bits each of red, green, blue; below 0 where nothing: (subrays,)."""
    bright: npt.NDArray[np.float64]
    """How bright each sub-ray is: (subrays,)."""
    draws: Draws
    """For drawing the boxes of a belt."""
    picks: Picks
    """For picking near ones from a belt."""
    cells: npt.NDArray[np.uint64]
    """Rows of an automaton's cells: (MAX_ROWS,)."""
    retina: npt.NDArray[np.uint8]
    """Of both eyes: (values,)."""


@compiled_allocating
def new_workspace(params: Params) -> Workspace:
    """The scratch that a thread needs for these worlds, eyes and agents."""
    world, eye, agents = params
    rays = eye.ahead.size
    columns = max(
        agents.boxes.shape[3],
        agents.turned.shape[3],
        agents.discs.shape[3],
        agents.sides.shape[3],
    )
    work = Workspace(
        _new_sieve(columns),
        np.empty((TURNED_ROWS, columns + LANES), np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float64),
        _new_draws(world),
        _new_picks(agents.belt_places.shape[3]),
        np.empty(MAX_ROWS, np.uint64),
        np.empty(agents.delayed.shape[2], np.uint8),
    )
    # An eye that does not turn looks along x for good.
    aim(eye, _ONE, _ZERO, work.ahead, work.left, work.per_ahead, work.per_left)
    return work


@compiled_allocating
def _new_sieve(columns: int) -> Sieve:
    numbers = np.arange(columns).astype(np.uint32)
    return Sieve(np.empty(columns, np.bool_), numbers, np.empty(columns + LANES, np.uint32))


@compiled_allocating
def _new_draws(world: WorldTables) -> Draws:
    chunks = max(1, world.planes[0].across)
    for plane in world.planes:
        chunks = max(chunks, plane.across)
    entries = chunks * world.counts.shape[3] + EIGHT
    return Draws(
        np.empty(chunks, np.uint64),
        np.empty(chunks, np.float64),
        np.empty(chunks, np.int64),
        np.empty(entries, np.uint64),
        np.empty(entries, np.float64),
    )


@compiled_allocating
def _new_picks(boxes: int) -> Picks:
    return Picks(
        np.empty(boxes, np.float32),
        np.empty(boxes, np.float32),
        np.empty(boxes, np.bool_),
        np.empty(boxes, np.int32),
    )
