"""Lists of the obstacles near an agent: all that it could see or meet from anywhere in its cell.

A list is longer than it ever needs to be (`MostNear`). If one should be full all the same, the
obstacles that it drops are counted (`Losses`), and whoever called the step raises an error.
"""

import math
from typing import NamedTuple

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
from reflexarc_sim_bridge.arrays.workspace import Losses, Workspace
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.intrinsics import LANES
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, corner_count, corner_m
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_NOWHERE = -(1 << 62)
"""The column of chunks of an agent that has not gathered yet."""


class Listing(NamedTuple):
    """The near lists of an agent while they are filled."""

    near: Near
    losses: Losses
    agent: int


@compiled_inline
def near_of(agents: Agents, i: int, number: int) -> Near:
    """The near lists of agent i in a layer."""
    return Near(
        agents.near_counts[i, number],
        agents.boxes[i, number],
        agents.turned[i, number],
        agents.discs[i, number],
        agents.sides[i, number],
    )


@compiled_inline
def listing_of(agents: Agents, work: Workspace, i: int, number: int) -> Listing:
    """The lists of agent i in a layer, to be filled."""
    return Listing(near_of(agents, i, number), work.losses, i)


@compiled_inline
def note_loss(losses: Losses, agent: int, kind: int, lost: int) -> None:
    """Count obstacles for which a list (its number in `LIST_NAMES`) has no room."""
    losses.counts[kind] += lost
    losses.agents[kind] = agent


@compiled_inline
def room_of(rows: Floats32) -> int:
    """How many columns a list holds at most; whole vectors may be written beyond them."""
    return int(rows.shape[1]) - LANES


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
    """Have all near lists of an agent made anew at its next step."""
    for number in range(agents.layer_cells.shape[1]):
        agents.layer_cells[i, number, 0] = _NOWHERE


@compiled_inner
def list_obstacle(
    listing: Listing, chunk: np.uint64, obstacle: Obstacle, x_m: float, y_m: float
) -> None:
    """Add an obstacle to the list of its kind.

    Args:
        listing: the lists.
        chunk: key of the chunk that its corners are drawn from.
        obstacle: the obstacle; one of kind NOTHING is skipped.
        x_m: its centre, from the corner of the agent's cell.
        y_m: the same.
    """
    near = listing.near
    if obstacle.kind == BOX:
        column = _next_column(listing, near.boxes, BOXES)
        _write_box(near.boxes, column, obstacle, x_m, y_m)
    elif obstacle.kind == TURNED_BOX:
        column = _next_column(listing, near.turned, TURNED)
        _write_box(near.turned, column, obstacle, x_m, y_m)
        near.turned[BOX_COS, column] = math.cos(obstacle.turned_rad)
        near.turned[BOX_SIN, column] = math.sin(obstacle.turned_rad)
    elif obstacle.kind == DISC:
        column = _next_column(listing, near.discs, DISCS)
        near.discs[DISC_X, column], near.discs[DISC_Y, column] = x_m, y_m
        near.discs[DISC_RADIUS, column] = obstacle.half_length_m
        near.discs[DISC_PAINT, column] = obstacle.paint
    elif obstacle.kind != NOTHING:
        _list_sides(listing, chunk, obstacle, x_m, y_m)


@compiled_inline
def _next_column(listing: Listing, rows: Floats32, kind: int) -> int:
    """The column of the next obstacle, which the list counts from now on.

    Where the list is full, it is a spare column, and the obstacle is counted as lost.
    """
    counts = listing.near.counts
    column = int(counts[kind])
    if column < room_of(rows):
        counts[kind] = column + 1
    else:
        note_loss(listing.losses, listing.agent, kind, 1)
    return column


@compiled_inline
def _write_box(rows: Floats32, k: int, obstacle: Obstacle, x_m: float, y_m: float) -> None:
    rows[BOX_X, k], rows[BOX_Y, k] = x_m, y_m
    rows[BOX_HALF_LENGTH, k] = obstacle.half_length_m
    rows[BOX_HALF_WIDTH, k] = obstacle.half_width_m
    rows[BOX_PAINT, k] = obstacle.paint


@compiled_inner
def _list_sides(
    listing: Listing, chunk: np.uint64, obstacle: Obstacle, x_m: float, y_m: float
) -> None:
    """Add all sides of a polygon, counter-clockwise; whole or not at all."""
    rows, counts, corners = listing.near.sides, listing.near.counts, corner_count(obstacle)
    k = counts[SIDES]
    if k + corners > room_of(rows):
        note_loss(listing.losses, listing.agent, SIDES, corners)
        return
    counts[SIDES] = k + corners
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
