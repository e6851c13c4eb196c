"""Scratch of one thread: no value in it is used after the look or the step that computed it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba.core import types

from reflexarc_sim_bridge.arrays.eyes import reciprocals
from reflexarc_sim_bridge.arrays.layout import (
    LIST_NAMES,
    MAX_ROWS,
    TILE_RAYS,
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

EIGHT = 8
"""Belt entries are written so many at a time: no branch predictor foresees a chunk's count."""

Picked = npt.NDArray[np.uint32]
Judged = npt.NDArray[np.bool_]


class Sieve(NamedTuple):
    """Scratch for picking obstacles out of a list: first judged one by one, then listed."""

    judged: Judged
    """Whether each obstacle passes, for example lies within a view: (capacity,)."""
    numbers: Picked
    """0, 1, 2, …: (capacity,)."""
    picked: Picked
    """Columns of those that pass: (capacity + LANES,)."""


class Faces(NamedTuple):
    """Straight faces of obstacles as coefficients of a ray's direction: see `vision/faces.py`.

    Each is (capacity,); a value is `…_x` · x + `…_y` · y for the direction (x, y).
    """

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


class Draws(NamedTuple):
    """Scratch for drawing one column of chunks of a belt: its chunks, and an entry a box."""

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
    """Scratch for picking near boxes: places of a belt's boxes relative to the agent's cell."""

    x_m: Floats32
    """From the corner of the cell: (capacity,)."""
    y_m: Floats32
    is_near: npt.NDArray[np.bool_]
    integers: Integers32
    """For moving rows of integers within themselves: (capacity,)."""


class Losses(NamedTuple):
    """Counts of near obstacles that had no room in a list. Any count above 0 is an error.

    Rows as `LIST_NAMES`.
    """

    counts: npt.NDArray[np.int64]
    """Obstacles, or sides or faces of them, since the counts were last reset: (lists,)."""
    agents: npt.NDArray[np.int64]
    """The agent whose list it was, the last time: (lists,)."""


class Workspace(NamedTuple):
    """All scratch of a thread, and the addresses of the functions that the step calls."""

    parts: "Parts"
    """Functions that are called by their address."""
    losses: Losses
    """Counts of obstacles that had no room in a list."""
    sieve: Sieve
    """For picking the obstacles that a tile of rays can meet."""
    seen: Floats32
    """The obstacles of a near list that the eye can see, relative to it, rows as there:
    (7 or 8, capacity)."""
    faces: Faces
    """Faces of turned boxes and polygons that the eye can see."""
    ahead: Floats32
    """Direction of each sub-ray in the world's frame: (subrays,); so the three below."""
    left: Floats32
    per_ahead: Floats32
    per_left: Floats32
    per_m: Floats32
    """1 / distance of the obstacles that a tile of rays meets: (TILE_RAYS,)."""
    distance_m: Floats32
    """Distance to the obstacle that each sub-ray met, the range where it met none: (subrays,)."""
    paint: Floats32
    """Its colour, 8 bits each of red, green, blue; below 0 where nothing: (subrays,)."""
    bright: npt.NDArray[np.float64]
    """Brightness of each sub-ray, 0 to 1: (subrays,)."""
    total: npt.NDArray[np.float64]
    """Sum of the brightness of a ray's sub-rays: (rays,)."""
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
    """Functions of a step that are compiled apart; address 0 where a world never calls one."""

    look: FunctionPointer = FunctionPointer(ON_AGENT)
    """`vision.sensing.sense_agent`."""
    put: FunctionPointer = FunctionPointer(ON_AGENT)
    """`motion.placing.go_to_free_place`."""
    gatherers: FunctionTable = function_table(IN_CELL, {}, (0, 2))
    """`gather` of each kind in `obstacles/kinds/`, and its `gather_belt`: (kinds, 2)."""


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
        seen=np.empty((agents.turned.shape[2], columns + LANES), np.float32),
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
