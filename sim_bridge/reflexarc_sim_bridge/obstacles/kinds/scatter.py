"""Obstacles scattered over the plane: how those near an agent are found, and how they are drawn.

White boxes around a period that is wide enough, and no wider than pays, are kept on a belt
(`belt.py`) and not gathered chunk by chunk.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    BOX,
    BOXES,
    OPEN,
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
    compiled_part,
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
from reflexarc_sim_bridge.obstacles.keys import chunk_key, column_key, layer_key
from reflexarc_sim_bridge.obstacles.near_lists import Listing, list_obstacle, listing_of, near_of
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle
from reflexarc_sim_bridge.obstacles.scatter_drawing import is_thinned, scatter_count, scattered
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_DIAGONAL = math.sqrt(2.0)
"""A box with half sides up to r reaches at most this many times r from its middle."""


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
    """List the near boxes of a scatter that has a belt: see `belt.py`."""
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
    chunk, drawn = chunk_of(world, seed, number, i, j, cells), 0
    plane, layer, key = chunk.plane, chunk.layer, chunk.layer_key
    shapes, counts = world.shapes[0, number], world.counts[0, number]
    for k in range(scatter_count(layer, counts, chunk.key, i)):
        if layer.gap_m > 0.0 and is_thinned(plane, layer, counts, key, i, j, k):
            continue
        drawn = drawn_row(chunk, scattered(plane, layer, shapes, chunk.key, j, k), rows, drawn)
    return drawn


@compiled_inline
def _belt_of(agents: Agents, i: int, number: int) -> Belt:
    return Belt(
        agents.belt_places[i, number], agents.belt_sizes[i, number], agents.belt_counts[i, number]
    )


@compiled_inline
def _is_in_reach(plane: Row, layer: Row, j: int, di: int, dj: int) -> bool:
    """Whether an obstacle of a chunk, `di` and `dj` chunks from the agent's cell, can be near."""
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
    """List the obstacles of one chunk, `di` and `dj` chunks from the agent's cell."""
    chunk_i, chunk_j = x + di, y + dj
    chunk = chunk_key(column_key(key, chunk_i), chunk_j, plane.across)
    for k in range(scatter_count(layer, counts, chunk, chunk_i)):
        obstacle = scattered(plane, layer, shapes, chunk, chunk_j, k)
        x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * plane.chunk_width_m
        if not _reaches_into(box, obstacle, x_m, y_m, layer.reach_m):
            continue
        if layer.gap_m > 0.0 and is_thinned(plane, layer, counts, key, chunk_i, chunk_j, k):
            continue
        list_obstacle(listing, chunk, obstacle, x_m, y_m)


@compiled_inline
def _reaches_into(box: NearBox, obstacle: Obstacle, x_m: float, y_m: float, reach_m: float) -> bool:
    """Whether an obstacle may reach into a box: boxes by their sides, others by `reach_m`."""
    away_x = max(box.back_m - x_m, x_m - box.front_m)
    away_y = max(box.right_m - y_m, y_m - box.left_m)
    if away_x <= obstacle.half_length_m and away_y <= obstacle.half_width_m:
        return True
    return obstacle.kind != BOX and max(away_x, away_y) <= reach_m
