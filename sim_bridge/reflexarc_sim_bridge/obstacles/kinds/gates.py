"""Walls across the way, drawn from seeds: one in every n-th column of chunks."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import BOX, Params, Table, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled, compiled_called, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import (
    between,
    first_half,
    joined,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.chunks import Chunk, draw_chunk, gather_chunks
from reflexarc_sim_bridge.obstacles.keys import column_key
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, nothing, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.kinds.gates import PIECES

_ZERO, _ONE = np.uint64(0), np.uint64(1)


@compiled_called
def gather(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List the pieces of walls near an agent: see `chunks.gather_chunks`."""
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
    """Draw the pieces of walls of a chunk: see `chunks.draw_chunk`."""
    return draw_chunk(world, seed, number, i, j, cells, rows, _count, _obstacle_at)


@compiled_inner
def _count(chunk: Chunk) -> int:
    return PIECES if chunk.i % chunk.layer.spacing_chunks == 0 else 0


@compiled_inner
def _obstacle_at(chunk: Chunk, index: int) -> Obstacle:
    """The piece of a wall within the chunk, on one side of the opening of one of two pitches."""
    plane, layer, j = chunk.plane, chunk.layer, chunk.j
    wall, pitch_m = column_key(chunk.layer_key, chunk.i), layer.pitch_m
    # Each wall's pitches begin somewhere else: otherwise their borders would be covered more.
    low_m = j * plane.chunk_width_m - uniform(number(wall, _ONE)) * pitch_m
    pitch = math.floor(low_m / pitch_m) + index // 2
    pitches = round(plane.width_m / pitch_m)
    own = pitch % pitches if plane.across > 0 else pitch
    bits = number(joined(wall, np.uint64(own)), _ZERO)
    opening_m = between(layer.opening_low_m, layer.opening_high_m, first_half(bits))
    begins_m = pitch * pitch_m + second_half(bits) * (pitch_m - opening_m)
    from_m, to_m = pitch * pitch_m, begins_m
    if index % 2:
        from_m, to_m = begins_m + opening_m, (pitch + 1) * pitch_m
    from_m, to_m = max(from_m, low_m), min(to_m, low_m + plane.chunk_width_m)
    if to_m <= from_m:
        return nothing()
    paint, half_m = paint_of(layer, wall, _ZERO), 0.5 * (to_m - from_m)
    y_m, thick_m = 0.5 * (from_m + to_m) - low_m, layer.half_thickness_m
    return Obstacle(BOX, 0.5 * CHUNK_M, y_m, thick_m, half_m, 0.0, 4, 0.0, _ZERO, paint)
