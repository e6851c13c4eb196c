"""What is near an agent: everything that it could see or meet from anywhere in its cell."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.belt import move_belt, pick_near
from reflexarc_sim_bridge.chunks import (
    Obstacle,
    Row,
    chunk_key,
    chunks_between,
    column_key,
    corner_count,
    corner_m,
    is_thinned,
    layer_key,
    scatter_count,
    scattered,
)
from reflexarc_sim_bridge.compiled import compiled_inline, compiled_inner
from reflexarc_sim_bridge.layers import CHUNK_M
from reflexarc_sim_bridge.params import (
    AT_REST,
    BOX,
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_PAINT,
    BOX_SIN,
    BOX_X,
    BOX_Y,
    BOXES,
    DISC,
    DISC_PAINT,
    DISC_RADIUS,
    DISC_X,
    DISC_Y,
    DISCS,
    DRIFT,
    NOTHING,
    OPEN,
    SCATTER,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_PAINT,
    SIDE_X,
    SIDE_Y,
    SIDES,
    TURNED,
    TURNED_BOX,
    Agents,
    Belt,
    Floats32,
    Near,
    Params,
    Table,
)
from reflexarc_sim_bridge.structures import structure_at, structure_count
from reflexarc_sim_bridge.workspace import Workspace

_NOWHERE = -(1 << 62)
"""The column of chunks of an agent that has not gathered yet."""
_DIAGONAL = math.sqrt(2.0)
"""What reaches so far along x and y reaches this much farther at most."""


@compiled_inline
def displacement_m(layer: Row, time_s: float) -> tuple[float, float]:
    """How far a layer has moved: ahead, left."""
    if layer.motion == AT_REST:
        return 0.0, 0.0
    if layer.motion == DRIFT:
        return layer.moves_ahead * time_s, layer.moves_left * time_s
    share = math.sin(2.0 * math.pi * time_s / layer.period_s)
    return layer.moves_ahead * share, layer.moves_left * share


@compiled_inline
def place_in_layer_m(
    plane: Row, layer: Row, state: Row, cell: npt.NDArray[np.int64]
) -> tuple[float, float]:
    """Where an agent is in a layer's frame, from the corner of its cell (2,) there."""
    if layer.motion == AT_REST:
        return state.x_m, state.y_m
    moved_x_m, moved_y_m = displacement_m(layer, state.steps * plane.dt_s)
    x_m = state.x_m - moved_x_m + (state.cell_x - cell[0]) * CHUNK_M
    return x_m, state.y_m - moved_y_m + (state.cell_y - cell[1]) * plane.chunk_width_m


@compiled_inline
def forget_near(agents: Agents, i: int) -> None:
    """Let all that is near an agent be gathered anew."""
    for number in range(agents.layer_cells.shape[1]):
        agents.layer_cells[i, number, 0] = _NOWHERE


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
            columns = x - cell[0]
            cell[0], cell[1] = x, y
            key, near = layer_key(plane.stream, state.seed, number), near_of(agents, i, number)
            shapes, counts = world.shapes[state.world, number], world.counts[state.world, number]
            if layer.has_belt:
                belt, shape = belt_of(agents, i, number), shapes[0]
                if columns != 0:
                    draws, picks = work.draws, work.picks
                    move_belt(plane, layer, shape, counts[0], key, x, columns, draws, picks, belt)
                if shape.kind == BOX:
                    near.counts[BOXES] = pick_near(plane, cell, work.picks, belt, near.boxes)
                else:
                    near.counts[TURNED] = pick_near(plane, cell, work.picks, belt, near.turned)
            elif layer.kind == SCATTER:
                _gather_scatter(plane, layer, shapes, counts, key, cell, near)
            else:
                _gather_structure(plane, layer, key, cell, near, work.cells)


@compiled_inline
def near_of(agents: Agents, i: int, number: int) -> Near:
    """What is near agent i in a layer."""
    return Near(
        agents.near_counts[i, number],
        agents.boxes[i, number],
        agents.turned[i, number],
        agents.discs[i, number],
        agents.sides[i, number],
    )


@compiled_inline
def belt_of(agents: Agents, i: int, number: int) -> Belt:
    """Its belt there."""
    return Belt(
        agents.belt_places[i, number], agents.belt_sizes[i, number], agents.belt_counts[i, number]
    )


@compiled_inline
def _is_beyond(x_m: float, length_m: float, y_m: float, width_m: float, farthest_m: float) -> bool:
    """Whether a chunk with its corner at (x, y) is farther from the agent's cell than so much.

    Both are `length` by `width`.
    """
    away_x, away_y = max(abs(x_m) - length_m, 0.0), max(abs(y_m) - width_m, 0.0)
    return away_x * away_x + away_y * away_y > farthest_m * farthest_m


@compiled_inline
def _farthest_in_reach_m(plane: Row, layer: Row) -> float:
    """Farther from an agent's cell no chunk holds anything that matters."""
    reach_m: float = _DIAGONAL * layer.reach_m
    return float(max(plane.ahead_m, plane.behind_m)) + reach_m


@compiled_inner
def _gather_scatter(
    plane: Row,
    layer: Row,
    shapes: Table,
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    cell: npt.NDArray[np.int64],
    near: Near,
) -> None:
    """List all obstacles of a scatter layer that reach into the box around an agent's cell."""
    side_m, reach_m = plane.chunk_width_m, layer.reach_m
    back_m, front_m = -plane.behind_m, CHUNK_M + plane.ahead_m
    right_m, left_m = -plane.aside_m, side_m + plane.aside_m
    first_i, last_i = chunks_between(back_m - reach_m, front_m + reach_m, CHUNK_M)
    first_j, last_j = chunks_between(right_m - reach_m, left_m + reach_m, side_m)
    farthest_m = _farthest_in_reach_m(plane, layer)
    is_open, box, turned, disc, side = plane.edges == OPEN, 0, 0, 0, 0
    for di in range(first_i, last_i + 1):
        i = cell[0] + di
        column = column_key(key, i)
        for dj in range(first_j, last_j + 1):
            j = cell[1] + dj
            if is_open and not 0 <= j < plane.across:
                continue
            if _is_beyond(di * CHUNK_M, CHUNK_M, dj * side_m, side_m, farthest_m):
                continue
            chunk = chunk_key(column, j, plane.across)
            for k in range(scatter_count(layer, counts, chunk, i)):
                obstacle = scattered(plane, layer, shapes, chunk, j, k)
                x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * side_m
                away_x = max(back_m - x_m, x_m - front_m)
                away_y = max(right_m - y_m, y_m - left_m)
                is_out = away_x > obstacle.half_length_m or away_y > obstacle.half_width_m
                if is_out and (obstacle.kind == BOX or max(away_x, away_y) > reach_m):
                    continue
                if layer.gap_m > 0.0 and is_thinned(plane, layer, counts, key, i, j, k):
                    continue
                if obstacle.kind == BOX:
                    box = _list_box(near.boxes, box, obstacle, x_m, y_m)
                elif obstacle.kind == TURNED_BOX:
                    turned = _list_turned(near.turned, turned, obstacle, x_m, y_m)
                elif obstacle.kind == DISC:
                    disc = _list_disc(near.discs, disc, obstacle, x_m, y_m)
                else:
                    side = _list_sides(near.sides, side, chunk, obstacle, x_m, y_m)
    near.counts[BOXES], near.counts[TURNED] = box, turned
    near.counts[DISCS], near.counts[SIDES] = disc, side


@compiled_inner
def _gather_structure(
    plane: Row,
    layer: Row,
    key: np.uint64,
    cell: npt.NDArray[np.int64],
    near: Near,
    cells: npt.NDArray[np.uint64],
) -> None:
    """The same for gates, corridors and automata: boxes, or polygons."""
    side_m, reach_m = plane.chunk_width_m, layer.reach_m
    first_i, last_i = chunks_between(
        -plane.behind_m - reach_m, CHUNK_M + plane.ahead_m + reach_m, CHUNK_M
    )
    first_j, last_j = chunks_between(
        -plane.aside_m - reach_m, side_m + plane.aside_m + reach_m, side_m
    )
    box, side = 0, 0
    for di in range(first_i, last_i + 1):
        for dj in range(first_j, last_j + 1):
            i, j = cell[0] + di, cell[1] + dj
            for k in range(structure_count(plane, layer, key, i, j, cells)):
                obstacle = structure_at(plane, layer, key, i, j, k, cells)
                x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * side_m
                if obstacle.kind == BOX:
                    box = _list_box(near.boxes, box, obstacle, x_m, y_m)
                elif obstacle.kind != NOTHING:
                    side = _list_sides(near.sides, side, key, obstacle, x_m, y_m)
    near.counts[BOXES], near.counts[SIDES] = box, side


@compiled_inline
def _list_box(rows: Floats32, k: int, obstacle: Obstacle, x_m: float, y_m: float) -> int:
    """Fill column k; returns the next."""
    rows[BOX_X, k], rows[BOX_Y, k] = x_m, y_m
    rows[BOX_HALF_LENGTH, k] = obstacle.half_length_m
    rows[BOX_HALF_WIDTH, k] = obstacle.half_width_m
    rows[BOX_PAINT, k] = obstacle.paint
    return min(k + 1, int(rows.shape[1]) - 1)


@compiled_inline
def _list_turned(rows: Floats32, k: int, obstacle: Obstacle, x_m: float, y_m: float) -> int:
    rows[BOX_COS, k], rows[BOX_SIN, k] = (
        math.cos(obstacle.turned_rad),
        math.sin(obstacle.turned_rad),
    )
    return int(_list_box(rows, k, obstacle, x_m, y_m))


@compiled_inline
def _list_disc(rows: Floats32, k: int, obstacle: Obstacle, x_m: float, y_m: float) -> int:
    rows[DISC_X, k], rows[DISC_Y, k] = x_m, y_m
    rows[DISC_RADIUS, k], rows[DISC_PAINT, k] = obstacle.half_length_m, obstacle.paint
    return min(k + 1, int(rows.shape[1]) - 1)


@compiled_inner
def _list_sides(
    rows: Floats32, k: int, chunk: np.uint64, obstacle: Obstacle, x_m: float, y_m: float
) -> int:
    """All sides of a polygon, counter-clockwise; whole or not at all."""
    corners = corner_count(obstacle)
    if k + corners > rows.shape[1]:
        return k
    cos, sin = math.cos(obstacle.turned_rad), math.sin(obstacle.turned_rad)
    dx_m, dy_m = corner_m(chunk, obstacle, corners - 1, cos, sin)
    x, y = np.float32(x_m + dx_m), np.float32(y_m + dy_m)
    for corner in range(corners):
        dx_m, dy_m = corner_m(chunk, obstacle, corner, cos, sin)
        next_x, next_y = np.float32(x_m + dx_m), np.float32(y_m + dy_m)
        rows[SIDE_X, k], rows[SIDE_Y, k] = x, y
        rows[SIDE_AHEAD, k], rows[SIDE_LEFT, k] = next_x - x, next_y - y
        rows[SIDE_PAINT, k] = obstacle.paint
        x, y, k = next_x, next_y, k + 1
    return k
