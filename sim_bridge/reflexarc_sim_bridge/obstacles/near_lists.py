"""Lists of the obstacles near an agent: all that it could see or meet from anywhere in its cell."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
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
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_PAINT,
    SIDE_X,
    SIDE_Y,
    SIDES,
    TURNED,
    TURNED_BOX,
    Agents,
    Floats32,
    Near,
    Row,
)
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.obstacles.chunks import Obstacle, corner_count, corner_m
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

_NOWHERE = -(1 << 62)
"""The column of chunks of an agent that has not gathered yet."""


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
def list_obstacle(near: Near, chunk: np.uint64, obstacle: Obstacle, x_m: float, y_m: float) -> None:
    """Add an obstacle to the list of its kind.

    Args:
        near: the lists.
        chunk: key of the chunk that its corners are drawn from.
        obstacle: which; it may be none.
        x_m: its centre, from the corner of the agent's cell.
        y_m: the same.
    """
    counts = near.counts
    if obstacle.kind == BOX:
        counts[BOXES] = _list_box(near.boxes, counts[BOXES], obstacle, x_m, y_m)
    elif obstacle.kind == TURNED_BOX:
        counts[TURNED] = _list_turned(near.turned, counts[TURNED], obstacle, x_m, y_m)
    elif obstacle.kind == DISC:
        counts[DISCS] = _list_disc(near.discs, counts[DISCS], obstacle, x_m, y_m)
    elif obstacle.kind != NOTHING:
        counts[SIDES] = _list_sides(near.sides, counts[SIDES], chunk, obstacle, x_m, y_m)


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
