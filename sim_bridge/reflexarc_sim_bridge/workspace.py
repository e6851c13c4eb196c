"""Scratch of one thread: nothing in it outlives the look or the step that filled it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.aim import aim
from reflexarc_sim_bridge.automaton import MAX_ROWS
from reflexarc_sim_bridge.belt import EIGHT, Draws, Picks
from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.faces import Faces, new_faces
from reflexarc_sim_bridge.params import TILE_RAYS, TURNED_ROWS, Floats32, Params, WorldTables
from reflexarc_sim_bridge.pick import Picked, Sieve
from reflexarc_sim_bridge.sieve import LANES

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


class Workspace(NamedTuple):
    """What an eye needs while it looks."""

    sieve: Sieve
    """For picking what a tile of rays can meet."""
    seen: Floats32
    """What the eye can see of a near list, relative to it, rows as there: (7, capacity)."""
    faces: Faces
    """What the eye can see of turned boxes and polygons."""
    ahead: Floats32
    """Direction of each sub-ray in the world's frame: (subrays,); so the three below."""
    left: Floats32
    per_ahead: Floats32
    per_left: Floats32
    per_m: Floats32
    """1 / distance of what a tile of rays meets: (TILE_RAYS,)."""
    distance_m: Floats32
    """What each sub-ray met, the range where nothing: (subrays,)."""
    paint: Floats32
    """Its colour, 8 bits each of red, green, blue; below 0 where nothing: (subrays,)."""
    bright: npt.NDArray[np.float64]
    """How bright each sub-ray is: (subrays,)."""
    total: npt.NDArray[np.float64]
    """The sum of a ray's: (rays,)."""
    lists: npt.NDArray[np.uint32]
    """Faces that each tile can meet: (tiles, capacity)."""
    ends: npt.NDArray[np.int64]
    """How many: (tiles,)."""
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
    layers, discs = agents.discs.shape[1], agents.discs.shape[3]
    boxes, turned, sides = agents.boxes.shape[3], agents.turned.shape[3], agents.sides.shape[3]
    faces = layers * (turned + sides) + LANES
    columns = max(boxes, turned, discs, sides)
    work = Workspace(
        _new_sieve(max(columns, faces)),
        np.empty((TURNED_ROWS, columns + LANES), np.float32),
        new_faces(faces),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(TILE_RAYS, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float32),
        np.empty(rays, np.float64),
        np.empty(eye.rays, np.float64),
        _lists(rays // TILE_RAYS, faces + LANES),
        np.empty(rays // TILE_RAYS, np.int64),
        _new_draws(world),
        _new_picks(agents.belt_places.shape[3]),
        np.empty(MAX_ROWS, np.uint64),
        np.empty(agents.delayed.shape[2], np.uint8),
    )
    # An eye that does not turn looks along x for good.
    aim(eye, _ONE, _ZERO, work.ahead, work.left, work.per_ahead, work.per_left)
    return work


@compiled_allocating
def _lists(tiles: int, capacity: int) -> Picked:
    """All of them, until they are chosen from."""
    lists = np.empty((tiles, capacity), np.uint32)
    for tile in range(tiles):
        for k in range(capacity):
            lists[tile, k] = k
    return lists


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
