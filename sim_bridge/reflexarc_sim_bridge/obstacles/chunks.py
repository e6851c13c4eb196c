"""Obstacles are generated from seeds chunk by chunk; nothing is stored.

A chunk is a rectangle of the plane, CHUNK_M along x. Its obstacles follow from (generator version,
seed, stream, layer, chunk i, chunk j) alone, so chunks can be asked for in any order, as often as
one likes, on any number of threads. Across a periodic world chunk j is chunk j modulo their
number. An obstacle belongs to the chunk of its centre; walls are cut at the borders of chunks.

A kind of layer has two functions, for the count of a chunk's obstacles and for its k-th obstacle;
the loops over chunks are here.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import NOTHING, Agents, Params, Row, Table, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner, compiled_part
from reflexarc_sim_bridge.obstacles.keys import chunk_key, chunks_between, column_key, layer_key
from reflexarc_sim_bridge.obstacles.near_lists import list_obstacle, listing_of
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, corner_count, corner_m
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.outlines import MAX_CORNERS

DRAWN_DTYPE = np.dtype(
    [
        ("kind", np.int64),
        ("x_m", np.float64),
        ("y_m", np.float64),
        # Of a disc.
        ("radius_m", np.float64),
        ("paint", np.int64),
        ("corners", np.int64),
        ("corner_x_m", np.float64, (MAX_CORNERS,)),
        ("corner_y_m", np.float64, (MAX_CORNERS,)),
    ],
    align=True,
)
"""An obstacle in the frame of its layer, for drawing."""


class Chunk(NamedTuple):
    """One chunk of a layer."""

    plane: Row
    """Row of `PLANE_DTYPE`."""
    layer: Row
    """Row of the table of layers."""
    layer_key: np.uint64
    """Key of the layer's random numbers."""
    key: np.uint64
    """Key of the chunk's own."""
    i: int
    """Its number along x."""
    j: int
    """Its number along y; beyond a period, too."""
    cells: npt.NDArray[np.uint64]
    """Scratch: (MAX_ROWS,)."""


class NearBox(NamedTuple):
    """The box around an agent's cell in which obstacles count as near, from the cell's corner."""

    back_m: float
    front_m: float
    right_m: float
    left_m: float


@compiled_part
def gather_chunks(
    params: Params,
    work: Workspace,
    i: int,
    number: int,
    x: int,
    y: int,
    count: Any,
    obstacle_at: Any,
) -> None:
    """Make the near lists of an agent in a layer anew.

    Args:
        params: the simulation.
        work: scratch.
        i: which agent.
        number: which layer.
        x: cell of the layer's frame that the agent has entered, along x.
        y: the same, along y.
        count: compiled: how many obstacles a `Chunk` has.
        obstacle_at: compiled: the obstacle of a `Chunk` with a number below that; its kind may be
            NOTHING.
    """
    world, state = params.world, params.agents.state[i]
    plane, layer = world.planes[state.world], world.layers[state.world, number]
    key = layer_key(plane.stream, state.seed, number)
    listing = listing_of(params.agents, work, i, number)
    begin_lists(params.agents, i, number, x, y)
    first_i, last_i, first_j, last_j = chunks_around(near_box(plane), plane, layer)
    for di in range(first_i, last_i + 1):
        for dj in range(first_j, last_j + 1):
            chunk = _chunk(plane, layer, key, x + di, y + dj, work.cells)
            for k in range(count(chunk)):
                obstacle = obstacle_at(chunk, k)
                x_m, y_m = obstacle.x_m + di * CHUNK_M, obstacle.y_m + dj * plane.chunk_width_m
                list_obstacle(listing, chunk.key, obstacle, x_m, y_m)


@compiled_part
def draw_chunk(
    world: WorldTables,
    seed: np.uint64,
    number: int,
    i: int,
    j: int,
    cells: npt.NDArray[np.uint64],
    rows: Table,
    count: Any,
    obstacle_at: Any,
) -> int:
    """Draw the obstacles of a chunk.

    Args:
        world: tables of the world; only their first row is used.
        seed: the world's.
        number: which layer.
        i: the chunk, along x.
        j: the chunk, along y.
        cells: scratch: (MAX_ROWS,).
        rows: filled until they are all used: `DRAWN_DTYPE`: (n,).
        count: see `gather_chunks`.
        obstacle_at: the same.

    Returns:
        How many there are; more than there are rows if these are too few.
    """
    chunk, drawn = chunk_of(world, seed, number, i, j, cells), 0
    for k in range(count(chunk)):
        drawn = drawn_row(chunk, obstacle_at(chunk, k), rows, drawn)
    return drawn


@compiled_part  # numba can hand on a row of a table within a tuple, but not return it
def chunk_of(
    world: WorldTables, seed: np.uint64, number: int, i: int, j: int, cells: npt.NDArray[np.uint64]
) -> Chunk:
    """A chunk of the first world of the tables; arguments as of `draw_chunk`."""
    plane, layer = world.planes[0], world.layers[0, number]
    return _chunk(plane, layer, layer_key(plane.stream, seed, number), i, j, cells)


@compiled_inline
def near_box(plane: Row) -> NearBox:
    """The box around an agent's cell in which obstacles count as near."""
    side_m = plane.chunk_width_m
    return NearBox(-plane.behind_m, CHUNK_M + plane.ahead_m, -plane.aside_m, side_m + plane.aside_m)


@compiled_inline
def chunks_around(box: NearBox, plane: Row, layer: Row) -> tuple[int, int, int, int]:
    """First and last chunk, along x and along y, of which an obstacle may reach into a box."""
    reach_m = layer.reach_m
    along = chunks_between(box.back_m - reach_m, box.front_m + reach_m, CHUNK_M)
    side_m = plane.chunk_width_m
    across = chunks_between(box.right_m - reach_m, box.left_m + reach_m, side_m)
    return along[0], along[1], across[0], across[1]


@compiled_inline
def begin_lists(agents: Agents, i: int, number: int, x: int, y: int) -> None:
    """Note the cell that an agent has entered in a layer, and empty its near lists."""
    cell, counts = agents.layer_cells[i, number], agents.near_counts[i, number]
    cell[0], cell[1] = x, y
    for kind in range(counts.size):
        counts[kind] = 0


@compiled_inner
def drawn_row(chunk: Chunk, obstacle: Obstacle, rows: Table, drawn: int) -> int:
    """Fill the next row with an obstacle, if there is a row; returns how many are drawn now."""
    if obstacle.kind == NOTHING:
        return drawn
    if drawn < len(rows):
        row = rows[drawn]
        row.kind, row.radius_m, row.paint = obstacle.kind, obstacle.half_length_m, obstacle.paint
        row.x_m = obstacle.x_m + chunk.i * CHUNK_M
        row.y_m = obstacle.y_m + chunk.j * chunk.plane.chunk_width_m
        row.corners = corner_count(obstacle)
        cos, sin = math.cos(obstacle.turned_rad), math.sin(obstacle.turned_rad)
        for corner in range(row.corners):
            dx_m, dy_m = corner_m(chunk.key, obstacle, corner, cos, sin)
            row.corner_x_m[corner], row.corner_y_m[corner] = row.x_m + dx_m, row.y_m + dy_m
    return drawn + 1


@compiled_part
def _chunk(
    plane: Row, layer: Row, key: np.uint64, i: int, j: int, cells: npt.NDArray[np.uint64]
) -> Chunk:
    return Chunk(plane, layer, key, chunk_key(column_key(key, i), j, plane.across), i, j, cells)
