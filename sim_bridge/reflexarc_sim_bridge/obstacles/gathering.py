"""Listing anew what is near an agent, one function for each way of finding it.

Each is compiled apart and called by its address (`parts.py`): a world of boxes has no use for the
code of corridors, and an agent enters another cell once in ten steps or more. All take the same:
parameters, scratch, which agent, which layer, and the cell of that layer which the agent has
entered.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    AT_REST,
    BOX,
    BOXES,
    OPEN,
    SCATTER,
    TURNED,
    Agents,
    Belt,
    Near,
    Params,
    Row,
)
from reflexarc_sim_bridge.arrays.workspace import Parts, Workspace
from reflexarc_sim_bridge.native.decorators import (
    compiled_called,
    compiled_inline,
    compiled_inner,
    compiled_part,
)
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer, call
from reflexarc_sim_bridge.obstacles.belt import move_belt, pick_near
from reflexarc_sim_bridge.obstacles.chunks import Obstacle, is_thinned, scatter_count, scattered
from reflexarc_sim_bridge.obstacles.keys import chunk_key, chunks_between, column_key, layer_key
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m, list_obstacle, near_of
from reflexarc_sim_bridge.obstacles.structures import structure_at, structure_count
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

_DIAGONAL = math.sqrt(2.0)
"""What reaches so far along x and y reaches this much farther at most."""


@compiled_inner
def keep_near(params: Params, work: Workspace, i: int) -> None:
    """Gather anew, layer by layer, where the agent has entered another cell."""
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane = world.planes[state.world]
    for number in range(plane.layers):
        layer, cell = world.layers[state.world, number], agents.layer_cells[i, number]
        moved_x_m, moved_y_m = displacement_m(layer, state.steps * plane.dt_s)
        x, y = state.cell_x, state.cell_y
        if layer.motion != AT_REST:
            x += math.floor((state.x_m - moved_x_m) / CHUNK_M)
            y += math.floor((state.y_m - moved_y_m) / plane.chunk_width_m)
        if x != cell[0] or y != cell[1]:
            call(_gatherer(layer, work.parts), (params, work, i, number, x, y))


@compiled_inline
def _gatherer(layer: Row, parts: Parts) -> FunctionPointer:
    """Address of the function that lists what is near in such a layer."""
    if layer.has_belt:
        return parts.belt
    return parts.scatter if layer.kind == SCATTER else parts.structure


@compiled_called
def gather_belt(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List what is near of a field of white boxes around a period: see `belt.py`."""
    world, agents, state = params.world, params.agents, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    shape, counts = world.shapes[state.world, number, 0], world.counts[state.world, number, 0]
    cell, key = agents.layer_cells[i, number], layer_key(plane.stream, state.seed, number)
    belt, near, columns = _belt_of(agents, i, number), near_of(agents, i, number), x - cell[0]
    cell[0], cell[1] = x, y
    if columns != 0:
        draws, picks = work.draws, work.picks
        move_belt(plane, layer, shape, counts, key, x, columns, draws, picks, belt)
    if shape.kind == BOX:
        near.counts[BOXES] = pick_near(plane, cell, work.picks, belt, near.boxes)
    else:
        near.counts[TURNED] = pick_near(plane, cell, work.picks, belt, near.turned)


@compiled_inline
def _belt_of(agents: Agents, i: int, number: int) -> Belt:
    return Belt(
        agents.belt_places[i, number], agents.belt_sizes[i, number], agents.belt_counts[i, number]
    )


class _Box(NamedTuple):
    """The box around an agent's cell in which things matter, from the cell's corner."""

    back_m: float
    front_m: float
    right_m: float
    left_m: float


@compiled_inline
def _box_of(plane: Row) -> _Box:
    side_m = plane.chunk_width_m
    return _Box(-plane.behind_m, CHUNK_M + plane.ahead_m, -plane.aside_m, side_m + plane.aside_m)


@compiled_inline
def _chunks_around(box: _Box, plane: Row, layer: Row) -> tuple[int, int, int, int]:
    """First and last chunk, along x and along y, of which an obstacle may reach into a box."""
    reach_m = layer.reach_m
    along = chunks_between(box.back_m - reach_m, box.front_m + reach_m, CHUNK_M)
    side_m = plane.chunk_width_m
    across = chunks_between(box.right_m - reach_m, box.left_m + reach_m, side_m)
    return along[0], along[1], across[0], across[1]


@compiled_called
def gather_scatter(params: Params, _: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List all obstacles of a scatter layer that reach into the box around an agent's cell."""
    world, agents, state = params.world, params.agents, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    shapes, counts = world.shapes[state.world, number], world.counts[state.world, number]
    cell, key = agents.layer_cells[i, number], layer_key(plane.stream, state.seed, number)
    near, box = near_of(agents, i, number), _box_of(plane)
    _enter(cell, x, y, near)
    first_i, last_i, first_j, last_j = _chunks_around(box, plane, layer)
    for di in range(first_i, last_i + 1):
        for dj in range(first_j, last_j + 1):
            if _is_in_reach(plane, layer, y + dj, di, dj):
                _gather_chunk(plane, layer, shapes, counts, key, cell, di, dj, box, near)


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
    cell: npt.NDArray[np.int64],
    di: int,
    dj: int,
    box: _Box,
    near: Near,
) -> None:
    """List those of one chunk, so far from the agent's cell."""
    chunk_i, chunk_j = cell[0] + di, cell[1] + dj
    chunk = chunk_key(column_key(key, chunk_i), chunk_j, plane.across)
    for k in range(scatter_count(layer, counts, chunk, chunk_i)):
        obstacle = scattered(plane, layer, shapes, chunk, chunk_j, k)
        x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * plane.chunk_width_m
        if not _reaches_into(box, obstacle, x_m, y_m, layer.reach_m):
            continue
        if layer.gap_m > 0.0 and is_thinned(plane, layer, counts, key, chunk_i, chunk_j, k):
            continue
        list_obstacle(near, chunk, obstacle, x_m, y_m)


@compiled_inline
def _reaches_into(box: _Box, obstacle: Obstacle, x_m: float, y_m: float, reach_m: float) -> bool:
    """Whether an obstacle may: a box as it is, all others by what any of them can reach."""
    away_x = max(box.back_m - x_m, x_m - box.front_m)
    away_y = max(box.right_m - y_m, y_m - box.left_m)
    if away_x <= obstacle.half_length_m and away_y <= obstacle.half_width_m:
        return True
    return obstacle.kind != BOX and max(away_x, away_y) <= reach_m


@compiled_called
def gather_structure(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List what is near of gates, corridors and automata: boxes, or polygons."""
    world, agents, state = params.world, params.agents, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    cell, key = agents.layer_cells[i, number], layer_key(plane.stream, state.seed, number)
    near = near_of(agents, i, number)
    _enter(cell, x, y, near)
    first_i, last_i, first_j, last_j = _chunks_around(_box_of(plane), plane, layer)
    for di in range(first_i, last_i + 1):
        for dj in range(first_j, last_j + 1):
            chunk_i, chunk_j = x + di, y + dj
            for k in range(structure_count(plane, layer, key, chunk_i, chunk_j, work.cells)):
                obstacle = structure_at(plane, layer, key, chunk_i, chunk_j, k, work.cells)
                x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * plane.chunk_width_m
                list_obstacle(near, key, obstacle, x_m, y_m)


@compiled_inline
def _enter(cell: npt.NDArray[np.int64], x: int, y: int, near: Near) -> None:
    """Note the new cell, and begin its lists."""
    cell[0], cell[1] = x, y
    for kind in range(near.counts.size):
        near.counts[kind] = 0
