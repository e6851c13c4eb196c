"""Two walls along a line through random knots, joined by cosines, drawn from seeds."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import NOTHING, WALL, Params, Row, Table, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled, compiled_called, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import between, number, uniform
from reflexarc_sim_bridge.obstacles.chunks import Chunk, draw_chunk, gather_chunks
from reflexarc_sim_bridge.obstacles.keys import column_key
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.kinds.corridor import WALL_SIDES, WALLS

WALL_THICKNESS_M = 0.3

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


@compiled
def corridor_middle_m(layer: Row, key: np.uint64, x_m: float) -> float:
    """Lateral place of the middle of a corridor: random knots, joined by half a cosine each."""
    knot = math.floor(x_m / layer.knot_m)
    here = 2.0 * uniform(number(column_key(key, knot), _ONE)) - 1.0
    there = 2.0 * uniform(number(column_key(key, knot + 1), _ONE)) - 1.0
    share = 0.5 - 0.5 * math.cos(math.pi * (x_m / layer.knot_m - knot))
    return float(layer.meander_m) * between(here, there, share)


@compiled
def corridor_line_m(layer: Row, key: np.uint64, x_m: float) -> float:
    """Lateral place of the middle between its walls, which are straight within each chunk."""
    i = math.floor(x_m / CHUNK_M)
    begin_m = corridor_middle_m(layer, key, i * CHUNK_M)
    end_m = corridor_middle_m(layer, key, (i + 1) * CHUNK_M)
    return between(begin_m, end_m, x_m / CHUNK_M - i)


@compiled_inner
def _count(chunk: Chunk) -> int:
    return WALLS


@compiled_inner
def _obstacle_at(chunk: Chunk, index: int) -> Obstacle:
    """The piece of the right (0) or left (1) wall in a chunk, outside of the corridor's width."""
    plane, layer, key, i, j = chunk.plane, chunk.layer, chunk.layer_key, chunk.i, chunk.j
    begin_m = corridor_middle_m(layer, key, i * CHUNK_M)
    end_m = corridor_middle_m(layer, key, (i + 1) * CHUNK_M)
    outwards_m = layer.half_width_m + 0.5 * WALL_THICKNESS_M
    y_m = 0.5 * (begin_m + end_m) + (outwards_m if index == 1 else -outwards_m)
    kind = WALL if math.floor(y_m / plane.chunk_width_m) == j else NOTHING
    y_m -= j * plane.chunk_width_m
    half_m, thick_m, rise_m = 0.5 * CHUNK_M, 0.5 * WALL_THICKNESS_M, 0.5 * (end_m - begin_m)
    paint = index if layer.stripes_m > 0.0 else paint_of(layer, key, _ZERO)
    return Obstacle(kind, half_m, y_m, half_m, thick_m, 0.0, WALL_SIDES, rise_m, _ZERO, paint)
