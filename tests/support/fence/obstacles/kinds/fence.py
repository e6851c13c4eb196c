"""Rows of posts across the way in compiled code."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import DISC, Params, Table, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled, compiled_called, compiled_inner
from reflexarc_sim_bridge.obstacles.chunks import Chunk, draw_chunk, gather_chunks
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_ZERO = np.uint64(0)


@compiled_called
def gather(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List the posts near an agent: see `chunks.gather_chunks`."""
    gather_chunks(params, work, i, number, x, y, _count, _obstacle_at)


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
    """Draw the posts of a chunk: see `chunks.draw_chunk`."""
    return draw_chunk(world, seed, number, i, j, cells, rows, _count, _obstacle_at)


@compiled_inner
def _count(chunk: Chunk) -> int:
    if chunk.i % chunk.layer.spacing_chunks != 0:
        return 0
    return _first_post(chunk, chunk.j + 1) - _first_post(chunk, chunk.j)


@compiled_inner
def _obstacle_at(chunk: Chunk, index: int) -> Obstacle:
    layer, radius_m = chunk.layer, chunk.layer.half_thickness_m
    post_m = (_first_post(chunk, chunk.j) + index) * layer.pitch_m
    y_m, paint = post_m - chunk.j * chunk.plane.chunk_width_m, paint_of(layer, chunk.key, _ZERO)
    return Obstacle(DISC, 0.5 * CHUNK_M, y_m, radius_m, radius_m, 0.0, 4, 0.0, _ZERO, paint)


@compiled_inner
def _first_post(chunk: Chunk, j: int) -> int:
    """Number of the first post that is not to the right of a chunk."""
    return math.ceil(j * chunk.plane.chunk_width_m / chunk.layer.pitch_m)
