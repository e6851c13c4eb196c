"""Scratch of one thread: nothing in it outlives the look or the step that filled it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba.core import types

from reflexarc_sim_bridge.arrays.eyes import reciprocals
from reflexarc_sim_bridge.arrays.layout import (
    LIST_NAMES,
    MAX_ROWS,
    TILE_RAYS,
    TURNED_ROWS,
    Floats32,
    Integers32,
    Params,
    WorldTables,
)
from reflexarc_sim_bridge.native.function_pointers import (
    FunctionPointer,
    FunctionTable,
    Signature,
    function_table,
)
from reflexarc_sim_bridge.native.intrinsics import LANES

Picked = npt.NDArray[np.uint32]


Judged = npt.NDArray[np.bool_]


class Sieve(NamedTuple):
    """Scratch for picking."""

    judged: Judged
    """Whether an eye or a tile of its rays can see an obstacle: (capacity,)."""
    numbers: Picked
    """0, 1, 2, …: (capacity,)."""
    picked: Picked
    """Columns of those that it can: (capacity + LANES,)."""


class Faces(NamedTuple):
    """What a ray's direction is multiplied with, x with x and y with y: (capacity,)."""

    one_x: Floats32
    """1 / length of a ray up to a face."""
    one_y: Floats32
    other_x: Floats32
    """The same of the other face that can be seen, or of the only one."""
    other_y: Floats32
    right_x: Floats32
    """≥ 0 for a ray to the left of the right end."""
    right_y: Floats32
    left_x: Floats32
    """≥ 0 for a ray to the right of the left end."""
    left_y: Floats32
    paint: Floats32


EIGHT = 8
"""Entries are written so many at a time: how many a chunk has, no branch foresees."""


class Draws(NamedTuple):
    """Scratch: the chunks of a column, and one entry for each of their boxes."""

    keys: npt.NDArray[np.uint64]
    """Key of each chunk: (chunks,)."""
    draws: npt.NDArray[np.float64]
    counts: npt.NDArray[np.int64]
    """Boxes of each chunk: (chunks,)."""
    numbers: npt.NDArray[np.uint64]
    """Where each box's random numbers begin: (entries,)."""
    chunks: npt.NDArray[np.float64]
    """Which chunk of the column each box is in: (entries,)."""


class Picks(NamedTuple):
    """Scratch: the boxes of a belt as an agent's cell has them."""

    x_m: Floats32
    """From the corner of the cell: (capacity,)."""
    y_m: Floats32
    is_near: npt.NDArray[np.bool_]
    integers: Integers32
    """For places that move: (capacity,)."""


class Losses(NamedTuple):
    """What was near an agent and had no room in a list: never anything, or the step fails.

    Rows as `LIST_NAMES`.
    """

    counts: npt.NDArray[np.int64]
    """How many obstacles or parts of them, since it was last looked up: (lists,)."""
    agents: npt.NDArray[np.int64]
    """Whose list it was, the last time: (lists,)."""


class Workspace(NamedTuple):
    """What an eye needs while it looks, and an agent while it moves."""

    parts: "Parts"
    """What they call."""
    losses: Losses
    """What had no room in a list."""
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


ON_AGENT = Signature("on_agent", Params, Workspace, types.int64)
"""Parameters, scratch, and which agent."""
IN_CELL = Signature(
    "in_cell", Params, Workspace, types.int64, types.int64, types.int64, types.int64
)
"""Parameters, scratch, which agent, which layer, and a cell (two integers)."""


class Parts(NamedTuple):
    """The parts of a step that are compiled apart; nowhere where a world never needs one."""

    look: FunctionPointer = FunctionPointer(ON_AGENT)
    """`vision.sensing.sense_agent`."""
    put: FunctionPointer = FunctionPointer(ON_AGENT)
    """`motion.placing.go_to_free_place`."""
    gatherers: FunctionTable = function_table(IN_CELL, {}, (0, 2))
    """What lists the obstacles of a kind that are near, without a belt and with one: (kinds, 2)."""


def new_workspace(params: Params, parts: Parts) -> Workspace:
    """The scratch that a thread needs for these worlds, eyes and agents."""
    world, eye, agents = params
    layers, boxes, discs = agents.layer_cells.shape[1], agents.boxes.shape[3], agents.discs.shape[3]
    turned, sides = agents.turned.shape[3], agents.sides.shape[3]
    columns, faces = max(boxes, turned, discs, sides), layers * (turned + sides) + LANES
    rays = len(eye.ahead)
    tiles = rays // TILE_RAYS
    everything = np.arange(max(columns, faces) + LANES, dtype=np.uint32)
    return Workspace(
        parts=parts,
        losses=Losses(*np.zeros((2, len(LIST_NAMES)), np.int64)),
        sieve=Sieve(np.empty(len(everything), np.bool_), everything, everything.copy()),
        seen=np.empty((TURNED_ROWS, columns + LANES), np.float32),
        faces=Faces(*np.empty((len(Faces._fields), faces), np.float32)),
        # An eye that does not turn looks along x for good.
        ahead=eye.ahead.copy(),
        left=eye.left.copy(),
        per_ahead=reciprocals(eye.ahead),
        per_left=reciprocals(eye.left),
        per_m=np.empty(TILE_RAYS, np.float32),
        distance_m=np.empty(rays, np.float32),
        paint=np.empty(rays, np.float32),
        bright=np.empty(rays, np.float64),
        total=np.empty(eye.rays, np.float64),
        # Until they are chosen from, all of them.
        lists=np.tile(everything, (tiles, 1)),
        ends=np.empty(tiles, np.int64),
        draws=_new_draws(world),
        picks=_new_picks(agents.belt_places.shape[3]),
        cells=np.empty(MAX_ROWS, np.uint64),
        retina=np.empty(agents.delayed.shape[2], np.uint8),
    )


def _new_draws(world: WorldTables) -> Draws:
    chunks = max(1, world.across)
    entries = chunks * world.counts.shape[3] + EIGHT
    return Draws(
        np.empty(chunks, np.uint64),
        np.empty(chunks, np.float64),
        np.empty(chunks, np.int64),
        np.empty(entries, np.uint64),
        np.empty(entries, np.float64),
    )


def _new_picks(boxes: int) -> Picks:
    return Picks(
        np.empty(boxes, np.float32),
        np.empty(boxes, np.float32),
        np.empty(boxes, np.bool_),
        np.empty(boxes, np.int32),
    )
