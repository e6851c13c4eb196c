"""Obstacles that are not scattered: gates, corridors, and the cells of an automaton.

gates       a wall across the way in every n-th column of chunks, one opening a pitch
corridor    two walls along a line through random knots, joined by cosines
automaton   cells full at random, smoothed; a row of full cells is one box
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import BOX, CORRIDOR, GATES, NOTHING, WALL, Row
from reflexarc_sim_bridge.native.decorators import compiled, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import (
    between,
    first_half,
    joined,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.automaton import find_run, full_cells, run_count
from reflexarc_sim_bridge.obstacles.chunks import Obstacle, nothing, paint_of
from reflexarc_sim_bridge.obstacles.keys import column_key
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

WALL_THICKNESS_M = 0.3
"""Of a corridor's walls."""

_ZERO, _ONE = np.uint64(0), np.uint64(1)
_GATE_PIECES = 4


@compiled_inner
def structure_count(
    plane: Row, layer: Row, key: np.uint64, i: int, j: int, cells: npt.NDArray[np.uint64]
) -> int:
    """How many obstacles a chunk has; some of them may be nothing.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of `LAYER_DTYPE`.
        key: key of the layer.
        i: the chunk, along x.
        j: the chunk, along y.
        cells: rows of an automaton's cells; filled where the layer is one: (MAX_ROWS,).
    """
    if layer.kind == GATES:
        return _GATE_PIECES if i % layer.spacing_chunks == 0 else 0
    if layer.kind == CORRIDOR:
        return 2
    full_cells(key, layer.cells, layer.fill, layer.smoothings, i, j, plane.across, cells)
    return run_count(cells, layer.cells)


@compiled_inner
def structure_at(
    plane: Row,
    layer: Row,
    key: np.uint64,
    i: int,
    j: int,
    index: int,
    cells: npt.NDArray[np.uint64],
) -> Obstacle:
    """Obstacle `index` of a chunk; arguments as for `structure_count`."""
    if layer.kind == GATES:
        return _gate_piece(plane, layer, key, i, j, index)
    if layer.kind == CORRIDOR:
        return _wall(plane, layer, key, i, j, index)
    return _run(plane, layer, key, i, j, index, cells)


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
    """The same of its walls, which are straight from one border of chunks to the next."""
    i = math.floor(x_m / CHUNK_M)
    begin_m = corridor_middle_m(layer, key, i * CHUNK_M)
    end_m = corridor_middle_m(layer, key, (i + 1) * CHUNK_M)
    return between(begin_m, end_m, x_m / CHUNK_M - i)


@compiled_inner
def _gate_piece(plane: Row, layer: Row, key: np.uint64, i: int, j: int, index: int) -> Obstacle:
    """What of a wall lies within the chunk: left or right of the opening of one of two pitches."""
    wall, pitch_m = column_key(key, i), layer.pitch_m
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


@compiled_inner
def _wall(plane: Row, layer: Row, key: np.uint64, i: int, j: int, index: int) -> Obstacle:
    """A chunk's length of the right or left wall, outside of the corridor's width."""
    begin_m = corridor_middle_m(layer, key, i * CHUNK_M)
    end_m = corridor_middle_m(layer, key, (i + 1) * CHUNK_M)
    outwards_m = layer.half_width_m + 0.5 * WALL_THICKNESS_M
    y_m = 0.5 * (begin_m + end_m) + (outwards_m if index == 1 else -outwards_m)
    kind = WALL if math.floor(y_m / plane.chunk_width_m) == j else NOTHING
    y_m -= j * plane.chunk_width_m
    half_m, thick_m, rise_m = 0.5 * CHUNK_M, 0.5 * WALL_THICKNESS_M, 0.5 * (end_m - begin_m)
    paint = paint_of(layer, key, _ZERO)
    return Obstacle(kind, half_m, y_m, half_m, thick_m, 0.0, 4, rise_m, _ZERO, paint)


@compiled_inner
def _run(
    plane: Row,
    layer: Row,
    key: np.uint64,
    i: int,
    j: int,
    index: int,
    cells: npt.NDArray[np.uint64],
) -> Obstacle:
    """A row of full cells."""
    row, first, last = find_run(cells, layer.cells, index)
    length_m, width_m = CHUNK_M / layer.cells, plane.chunk_width_m / layer.cells
    half_m, y_m = 0.5 * (last + 1 - first) * width_m, 0.5 * (first + last + 1) * width_m
    x_m, half_length_m = (row + 0.5) * length_m, 0.5 * length_m
    own = j % plane.across if plane.across > 0 else j
    paint = paint_of(layer, joined(column_key(key, i), np.uint64(own)), np.uint64(index))
    return Obstacle(BOX, x_m, y_m, half_length_m, half_m, 0.0, 4, 0.0, _ZERO, paint)
