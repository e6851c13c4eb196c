"""Obstacles scattered over the plane, drawn from seeds.

The count of a chunk is Poisson's; then every obstacle has a block of random numbers. White boxes
around a wide enough period are kept on a belt (`belt.py`) and not gathered chunk by chunk.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    BOX,
    BOXES,
    CURVE,
    DISC,
    OPEN,
    POLYGON,
    TURNED,
    Agents,
    Belt,
    Params,
    Row,
    Table,
    WorldTables,
)
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import (
    compiled,
    compiled_called,
    compiled_inline,
    compiled_inner,
    compiled_part,
)
from reflexarc_sim_bridge.native.splitmix64 import (
    between,
    first_half,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.belt import move_belt, pick_near
from reflexarc_sim_bridge.obstacles.chunks import (
    NearBox,
    begin_lists,
    chunk_of,
    chunks_around,
    drawn_row,
    near_box,
)
from reflexarc_sim_bridge.obstacles.keys import (
    BLOCK,
    KIND,
    MARK,
    OUTLINE,
    PLACE,
    SIZE,
    chunk_key,
    column_key,
    layer_key,
)
from reflexarc_sim_bridge.obstacles.near_lists import Listing, list_obstacle, listing_of, near_of
from reflexarc_sim_bridge.obstacles.obstacle import WHITE, Obstacle, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.shapes import LOBES

_DIAGONAL = math.sqrt(2.0)
"""What reaches so far along x and y reaches this much farther at most."""
_NEIGHBOURS = 9


@compiled_called
def gather(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List all obstacles of a scatter that reach into the box around an agent's cell."""
    world, state = params.world, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    shapes, counts = world.shapes[state.world, number], world.counts[state.world, number]
    key, box = layer_key(plane.stream, state.seed, number), near_box(plane)
    listing = listing_of(params.agents, work, i, number)
    begin_lists(params.agents, i, number, x, y)
    first_i, last_i, first_j, last_j = chunks_around(box, plane, layer)
    for di in range(first_i, last_i + 1):
        for dj in range(first_j, last_j + 1):
            if _is_in_reach(plane, layer, y + dj, di, dj):
                _gather_chunk(plane, layer, shapes, counts, key, x, y, di, dj, box, listing)


@compiled_called
def gather_belt(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """The same of white boxes around a period, from a belt: see `belt.py`."""
    world, agents, state = params.world, params.agents, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    shape, counts = world.shapes[state.world, number, 0], world.counts[state.world, number, 0]
    cell, key = agents.layer_cells[i, number], layer_key(plane.stream, state.seed, number)
    belt, near, columns = _belt_of(agents, i, number), near_of(agents, i, number), x - cell[0]
    cell[0], cell[1] = x, y
    if columns != 0:
        move_belt(plane, layer, shape, counts, key, x, columns, work, i, belt)
    if shape.kind == BOX:
        near.counts[BOXES] = pick_near(plane, cell, work, i, belt, near.boxes, BOXES)
    else:
        near.counts[TURNED] = pick_near(plane, cell, work, i, belt, near.turned, TURNED)


@compiled
def draw(
    world: WorldTables,
    seed: np.uint64,
    number: int,
    i: int,
    j: int,
    cells: npt.NDArray[np.uint64],
    rows: Table,
) -> int:
    """Draw all obstacles of a chunk: arguments and result as of `chunks.draw_chunk`."""
    chunk, shapes, counts = (
        chunk_of(world, seed, number, i, j, cells),
        world.shapes[0, number],
        world.counts[0, number],
    )
    plane, layer, drawn = chunk.plane, chunk.layer, 0
    for index in range(_count(layer, counts, chunk.key, i)):
        thinned = layer.gap_m > 0.0 and _is_thinned(
            plane, layer, counts, chunk.layer_key, i, j, index
        )
        if not thinned:
            obstacle = _obstacle_at(plane, layer, shapes, chunk.key, j, index)
            drawn = drawn_row(chunk, obstacle, rows, drawn)
    return drawn


@compiled_inline
def _belt_of(agents: Agents, i: int, number: int) -> Belt:
    return Belt(
        agents.belt_places[i, number], agents.belt_sizes[i, number], agents.belt_counts[i, number]
    )


@compiled_inline
def _is_in_reach(plane: Row, layer: Row, j: int, di: int, dj: int) -> bool:
    """Whether a chunk, so far from the agent's cell, holds anything that matters."""
    if plane.edges == OPEN and not 0 <= j < plane.across:
        return False
    side_m = plane.chunk_width_m
    away_x = max(abs(di * CHUNK_M) - CHUNK_M, 0.0)
    away_y = max(abs(dj * side_m) - side_m, 0.0)
    reach_m: float = _DIAGONAL * layer.reach_m
    farthest_m = float(max(plane.ahead_m, plane.behind_m)) + reach_m
    return bool(away_x * away_x + away_y * away_y <= farthest_m * farthest_m)


@compiled_part
def _gather_chunk(
    plane: Row,
    layer: Row,
    shapes: npt.NDArray[np.void],
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    x: int,
    y: int,
    di: int,
    dj: int,
    box: NearBox,
    listing: Listing,
) -> None:
    """List those of one chunk, so far from the agent's cell."""
    chunk_i, chunk_j = x + di, y + dj
    chunk = chunk_key(column_key(key, chunk_i), chunk_j, plane.across)
    for k in range(_count(layer, counts, chunk, chunk_i)):
        obstacle = _obstacle_at(plane, layer, shapes, chunk, chunk_j, k)
        x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * plane.chunk_width_m
        if not _reaches_into(box, obstacle, x_m, y_m, layer.reach_m):
            continue
        if layer.gap_m > 0.0 and _is_thinned(plane, layer, counts, key, chunk_i, chunk_j, k):
            continue
        list_obstacle(listing, chunk, obstacle, x_m, y_m)


@compiled_inline
def _reaches_into(box: NearBox, obstacle: Obstacle, x_m: float, y_m: float, reach_m: float) -> bool:
    """Whether an obstacle may: a box as it is, all others by what any of them can reach."""
    away_x = max(box.back_m - x_m, x_m - box.front_m)
    away_y = max(box.right_m - y_m, y_m - box.left_m)
    if away_x <= obstacle.half_length_m and away_y <= obstacle.half_width_m:
        return True
    return obstacle.kind != BOX and max(away_x, away_y) <= reach_m


@compiled_inline
def _count(layer: Row, counts: npt.NDArray[np.float64], chunk: np.uint64, i: int) -> int:
    """How many obstacles of a scatter layer a chunk has.

    The Poisson draw is inverted: as many as there are counts whose probability it has passed. All
    are compared, for no branch foresees where to stop.

    Args:
        layer: row of the table of layers.
        counts: probability of at most so many, by section: (sections, counts).
        chunk: key of the chunk.
        i: the chunk, along x.
    """
    section = 0 if layer.sections == 1 else (i // layer.section_chunks) % layer.sections
    draw, count = uniform(number(chunk, np.uint64(0))), 0
    for k in range(counts.shape[1]):
        count += draw >= counts[section, k]
    return count


@compiled_inline
def _obstacle_at(
    plane: Row, layer: Row, shapes: Table, chunk: np.uint64, j: int, index: int
) -> Obstacle:
    """Obstacle `index` of a chunk of a scatter layer, before any thinning.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of the table of layers.
        shapes: rows of `SHAPE_DTYPE`: (shapes,).
        chunk: key of the chunk.
        j: the chunk, along y.
        index: which of its obstacles.
    """
    block = np.uint64(index) * BLOCK
    which, turn = 0, 0.0
    if layer.is_plain == 0:
        bits = number(chunk, block + KIND)
        turn, drawn = second_half(bits), first_half(bits)
        while which < layer.shapes - 1 and drawn >= shapes[which].share_up_to:
            which += 1
    shape = shapes[which]
    size = number(chunk, block + SIZE)
    across = between(shape.size_low, shape.size_high, first_half(size))
    kind, corners, dent = shape.kind, 4, 0.0
    half_length_m, half_width_m = across, across
    if kind in (POLYGON, CURVE):
        corners, dent = _form(shape, number(chunk, block + OUTLINE))
    elif kind != DISC:
        half_width_m = 0.5 * across
        half_length_m = 0.5 * between(shape.length_low, shape.length_high, second_half(size))
    x_m, y_m = _place_m(plane, chunk, index, j, half_width_m)
    turned_rad = between(shape.turned_low, shape.turned_high, turn)
    paint = WHITE if layer.is_white else paint_of(layer, chunk, block)
    return Obstacle(
        kind, x_m, y_m, half_length_m, half_width_m, turned_rad, corners, dent, block, paint
    )


@compiled_inner
def _is_thinned(
    plane: Row,
    layer: Row,
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    i: int,
    j: int,
    index: int,
) -> bool:
    """Matérn's second rule: a centre with a lower mark lies within the gap."""
    chunk = chunk_key(column_key(key, i), j, plane.across)
    mark = number(chunk, np.uint64(index) * BLOCK + MARK)
    x_m, y_m = _place_m(plane, chunk, index, j, 0.0)
    for neighbour in range(_NEIGHBOURS):
        di, dj = neighbour // 3 - 1, neighbour % 3 - 1
        other = chunk_key(column_key(key, i + di), j + dj, plane.across)
        for k in range(_count(layer, counts, other, i + di)):
            if number(other, np.uint64(k) * BLOCK + MARK) < mark:
                other_x_m, other_y_m = _place_m(plane, other, k, j + dj, 0.0)
                dx_m = other_x_m + di * CHUNK_M - x_m
                dy_m = other_y_m + dj * plane.chunk_width_m - y_m
                if dx_m * dx_m + dy_m * dy_m < layer.gap_m * layer.gap_m:
                    return True
    return False


@compiled_inline
def _place_m(
    plane: Row, chunk: np.uint64, index: int, j: int, half_width_m: float
) -> tuple[float, float]:
    """Centre of an obstacle, from the corner of its chunk.

    With open edges the whole obstacle lies between them: a place that is uniform over the width is
    mapped to one that is uniform over what fits.
    """
    bits = number(chunk, np.uint64(index) * BLOCK + PLACE)
    y_m = second_half(bits) * plane.chunk_width_m
    if plane.edges == OPEN:
        corner_m = j * plane.chunk_width_m
        fits = 1.0 - 2.0 * half_width_m / plane.width_m
        y_m = half_width_m + (corner_m + y_m) * fits - corner_m
    return first_half(bits) * CHUNK_M, y_m


@compiled_inner
def _form(shape: Row, bits: np.uint64) -> tuple[int, float]:
    """Corners and dent of a polygon, lobes and waviness of a curve."""
    dent = between(shape.dent_low, shape.dent_high, second_half(bits))
    if shape.kind == CURVE:
        return LOBES[0] + int((LOBES[1] + 1 - LOBES[0]) * first_half(bits)), dent
    span = shape.corners_high + 1 - shape.corners_low
    return shape.corners_low + int(span * first_half(bits)), dent
