"""A field of white boxes across a periodic world: the common case, in vectors.

An agent's belt holds all boxes of the columns of chunks within its reach, over the whole period.
Its near boxes are picked from there. When the agent moves aside, or to another place after a
contact, no box has to be drawn from a seed; when it enters another column of chunks, the belt loses
one column and gains one.

Places on a belt are 32-bit integers that wrap: along x 1/2²⁴ of a chunk, across 1/2³² of the
period. The difference of two is right whichever way round it is, up to half a period, and the same
after a metre or a thousand kilometres. Boxes that can be seen or met are those that the function
`gather` of `kinds/scatter.py` lists, but for rounding (0.2 µm); of boxes beyond, a belt lists a few
more.

All work is in phases over flat arrays, each of which the compiler turns into vector instructions.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    BELT,
    BELT_X,
    BELT_Y,
    BOX,
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_PAINT,
    BOX_SIN,
    BOX_X,
    BOX_Y,
    COS,
    HALF_LENGTH,
    HALF_WIDTH,
    SIN,
    TURNED_BOX,
    TURNED_ROWS,
    WHITE,
    Belt,
    Floats32,
    Integers32,
    Row,
)
from reflexarc_sim_bridge.arrays.workspace import Picks, Workspace
from reflexarc_sim_bridge.native.decorators import (
    compiled_disjoint,
    compiled_inline,
    compiled_inner,
    compiled_part,
)
from reflexarc_sim_bridge.native.intrinsics import LANES, keep, whole
from reflexarc_sim_bridge.obstacles.belt_drawing import (
    CHUNK_BITS,
    TURN,
    draw_boxes,
    place_boxes,
    turn_boxes,
)
from reflexarc_sim_bridge.obstacles.keys import chunks_between, column_key
from reflexarc_sim_bridge.obstacles.near_lists import note_loss, room_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_WHITE = np.float32(WHITE)


@compiled_inner
def move_belt(
    plane: Row,
    layer: Row,
    shape: Row,
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    column: int,
    steps: int,
    work: Workspace,
    agent: int,
    belt: Belt,
) -> None:
    """Have a belt hold the boxes within reach from a column of chunks.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of the table of layers.
        shape: row of `SHAPE_DTYPE`.
        counts: probability of at most so many in a chunk: (counts,).
        key: key of the layer.
        column: the agent's.
        steps: how many columns it has gone since it was here last; 1 keeps all but one of them.
        work: scratch.
        agent: whose belt it is.
        belt: moved.
    """
    reach_m = layer.reach_m
    first, last = chunks_between(
        -plane.behind_m - reach_m, CHUNK_M + plane.ahead_m + reach_m, CHUNK_M
    )
    columns, kept, end = last + 1 - first, 0, 0
    if steps == 1:
        rows = 2 if shape.kind == BOX else 4
        kept, end = columns - 1, _drop_first(columns, rows, belt, work.picks)
    for k in range(kept, columns):
        i, begun = column + first + k, end
        boxes = place_boxes(plane.across, counts, column_key(key, i), work.draws)
        end = _fitting(begun + boxes, belt, work, agent)
        _draw_column(plane, shape, i, work, belt, begun, end)
        belt.counts[k] = end - begun
    for k in range(columns, belt.counts.size):  # of a world that the agent was in before
        belt.counts[k] = 0


@compiled_inner
def pick_near(
    plane: Row,
    cell: npt.NDArray[np.int64],
    work: Workspace,
    agent: int,
    belt: Belt,
    boxes: Floats32,
    kind: int,
) -> int:
    """List the boxes of a belt that reach into the box around an agent's cell.

    Args:
        plane: row of `PLANE_DTYPE`.
        cell: the agent's: (2,).
        work: scratch.
        agent: which.
        belt: its belt.
        boxes: filled, rows BOX_*, those for turned boxes if there are any: (5 to 8, capacity).
        kind: which list that is: BOXES or TURNED.

    Returns:
        How many.
    """
    end, is_upright, picks = 0, boxes.shape[0] < TURNED_ROWS, work.picks
    for count in belt.counts:
        end += count
    x_m, y_m, is_near, sizes = picks.x_m, picks.y_m, picks.is_near, belt.sizes
    _judge(plane, cell, x_m, y_m, is_near, belt.places, sizes, end, is_upright)
    n, room = _list(is_near, x_m, end, boxes[BOX_X]), room_of(boxes)
    if n > room:
        note_loss(work.losses, agent, kind, _marked(is_near, end) - room)
        n = room
    _list(is_near, y_m, end, boxes[BOX_Y])
    _list_sizes(is_near, sizes, end, boxes, is_upright)
    for k in range(n):
        boxes[BOX_PAINT, k] = _WHITE
    return n


@compiled_part
def _fitting(wanted: int, belt: Belt, work: Workspace, agent: int) -> int:
    """How many of `wanted` boxes a belt has room for; the others are counted as lost."""
    end = min(wanted, int(belt.places.shape[1]))
    if end < wanted:
        note_loss(work.losses, agent, BELT, wanted - end)
    return end


@compiled_part
def _draw_column(
    plane: Row, shape: Row, i: int, work: Workspace, belt: Belt, begun: int, end: int
) -> None:
    """Draw the boxes of column i of chunks: entries `begun` to `end` of a belt."""
    draw_boxes(plane, shape, i, work.draws, belt, begun, end)
    if shape.kind == TURNED_BOX:
        turn_boxes(shape, work.draws, belt, begun, end)


@compiled_inline
def _drop_first(columns: int, rows: int, belt: Belt, picks: Picks) -> int:
    """Drop the column of chunks that lies farthest back; returns how many boxes are left."""
    gone, left = belt.counts[0], 0
    for k in range(1, columns):
        left += belt.counts[k]
        belt.counts[k - 1] = belt.counts[k]
    for row in range(2):
        _move_down(belt.places[row], belt.places[row, gone:], left, picks.integers)
    for row in range(rows):
        _move_down(belt.sizes[row], belt.sizes[row, gone:], left, picks.x_m)
    return left


@compiled_inline
def _move_down(
    row: npt.NDArray[Any], kept: npt.NDArray[Any], left: int, scratch: npt.NDArray[Any]
) -> None:
    """Move a row within itself through scratch: copies between two arrays become vectors."""
    _copy(kept, left, scratch)
    _copy(scratch, left, row)


@compiled_disjoint
def _copy(values: npt.NDArray[Any], count: int, copies: npt.NDArray[Any]) -> None:
    for k in range(count):
        copies[k] = values[k]


@compiled_disjoint
def _judge(
    plane: Row,
    cell: npt.NDArray[np.int64],
    x_m: Floats32,
    y_m: Floats32,
    is_near: npt.NDArray[np.bool_],
    places: Integers32,
    sizes: Floats32,
    end: int,
    is_upright: bool,
) -> None:
    """Compute the places of a belt's boxes from a cell, and mark those that reach into its box."""
    length_m, width_m = CHUNK_M + plane.ahead_m + plane.behind_m, plane.chunk_width_m
    middle_x, half_x = np.float32(0.5 * length_m - plane.behind_m), np.float32(0.5 * length_m)
    middle_y, half_y = np.float32(0.5 * width_m), np.float32(0.5 * width_m + plane.aside_m)
    unit_x = np.float32(CHUNK_M / (1 << CHUNK_BITS))
    unit_y = np.float32(plane.chunk_width_m * plane.across / TURN)
    corner_x = np.int32(cell[0] << CHUNK_BITS)
    corner_y = np.int32(np.int64((cell[1] % plane.across) * (TURN / plane.across)))
    for k in range(whole(end)):
        x = np.float32(np.int32(places[BELT_X, k] - corner_x)) * unit_x
        y = np.float32(np.int32(places[BELT_Y, k] - corner_y)) * unit_y
        x_m[k], y_m[k] = x, y
        half_length, half_width = sizes[HALF_LENGTH, k], sizes[HALF_WIDTH, k]
        longest = half_length if is_upright else half_length + half_width
        widest = half_width if is_upright else half_length + half_width
        is_near[k] = (
            (k < end)
            & (abs(x - middle_x) <= half_x + longest)
            & (abs(y - middle_y) <= half_y + widest)
        )


@compiled_disjoint
def _list(is_near: npt.NDArray[np.bool_], values: Floats32, end: int, listed: Floats32) -> int:
    """List a value of the near ones; returns how many are listed, more than fit if not all are."""
    n, room = 0, len(listed) - LANES
    for first in range(0, end, LANES):
        if n > room:
            return n
        n = keep(values, is_near, first, listed, n)
    return n


@compiled_part
def _list_sizes(
    is_near: npt.NDArray[np.bool_], sizes: Floats32, end: int, boxes: Floats32, is_upright: bool
) -> None:
    """List half the sides of the near ones, and the angles of turned ones."""
    _list(is_near, sizes[HALF_LENGTH], end, boxes[BOX_HALF_LENGTH])
    _list(is_near, sizes[HALF_WIDTH], end, boxes[BOX_HALF_WIDTH])
    if not is_upright:
        _list(is_near, sizes[COS], end, boxes[BOX_COS])
        _list(is_near, sizes[SIN], end, boxes[BOX_SIN])


@compiled_inner
def _marked(marks: npt.NDArray[np.bool_], end: int) -> int:
    """How many of the first ones are marked."""
    count = 0
    for k in range(end):
        count += marks[k]
    return count
