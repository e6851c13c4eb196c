"""Drawing the obstacles of a scatter from their seeds.

The count of a chunk is Poisson's; then every obstacle has a block of random numbers (`keys.py`).
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import CURVE, DISC, OPEN, POLYGON, WHITE, Row, Table
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import (
    between,
    first_half,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.keys import (
    BLOCK,
    KIND,
    MARK,
    OUTLINE,
    PLACE,
    SIZE,
    chunk_key,
    column_key,
)
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.shapes import LOBES

_NEIGHBOURS = 9
"""Chunks in which a centre may lie that is closer than the gap."""


@compiled_inline
def scatter_count(layer: Row, counts: npt.NDArray[np.float64], chunk: np.uint64, i: int) -> int:
    """How many obstacles of a scatter layer a chunk has.

    The Poisson draw is inverted: as many as there are counts whose probability it has passed. All
    are compared: a branch predictor could not foresee where to stop.

    Args:
        layer: row of the table of layers.
        counts: probability of at most so many, by section: (sections, counts).
        chunk: key of the chunk.
        i: the chunk, along x.
    """
    section = 0 if layer.sections == 1 else (i // layer.section_chunks) % layer.sections
    draw, count = uniform(number(chunk, np.uint64(0))), 0
    for k in range(counts.shape[1]):
        count += draw >= counts[section, k]
    return count


@compiled_inline
def scattered(
    plane: Row, layer: Row, shapes: Table, chunk: np.uint64, j: int, index: int
) -> Obstacle:
    """Obstacle `index` of a chunk of a scatter layer, before any thinning.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of the table of layers.
        shapes: rows of `SHAPE_DTYPE`: (shapes,).
        chunk: key of the chunk.
        j: the chunk, along y.
        index: which of its obstacles.
    """
    block = np.uint64(index) * BLOCK
    which, turn = 0, 0.0
    if layer.is_plain == 0:
        bits = number(chunk, block + KIND)
        turn, drawn = second_half(bits), first_half(bits)
        while which < layer.shapes - 1 and drawn >= shapes[which].share_up_to:
            which += 1
    shape = shapes[which]
    size = number(chunk, block + SIZE)
    across = between(shape.size_low, shape.size_high, first_half(size))
    kind, corners, dent = shape.kind, 4, 0.0
    half_length_m, half_width_m = across, across
    if kind in (POLYGON, CURVE):
        corners, dent = _form(shape, number(chunk, block + OUTLINE))
    elif kind != DISC:
        half_width_m = 0.5 * across
        half_length_m = 0.5 * between(shape.length_low, shape.length_high, second_half(size))
    x_m, y_m = _place_m(plane, chunk, index, j, half_width_m)
    turned_rad = between(shape.turned_low, shape.turned_high, turn)
    paint = WHITE if layer.is_white else paint_of(layer, chunk, block)
    return Obstacle(
        kind, x_m, y_m, half_length_m, half_width_m, turned_rad, corners, dent, block, paint
    )


@compiled_inner
def is_thinned(
    plane: Row,
    layer: Row,
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    i: int,
    j: int,
    index: int,
) -> bool:
    """Matérn's second rule: a centre with a lower mark lies within the gap."""
    chunk = chunk_key(column_key(key, i), j, plane.across)
    mark = number(chunk, np.uint64(index) * BLOCK + MARK)
    x_m, y_m = _place_m(plane, chunk, index, j, 0.0)
    for neighbour in range(_NEIGHBOURS):
        di, dj = neighbour // 3 - 1, neighbour % 3 - 1
        other = chunk_key(column_key(key, i + di), j + dj, plane.across)
        for k in range(scatter_count(layer, counts, other, i + di)):
            if number(other, np.uint64(k) * BLOCK + MARK) < mark:
                other_x_m, other_y_m = _place_m(plane, other, k, j + dj, 0.0)
                dx_m = other_x_m + di * CHUNK_M - x_m
                dy_m = other_y_m + dj * plane.chunk_width_m - y_m
                if dx_m * dx_m + dy_m * dy_m < layer.gap_m * layer.gap_m:
                    return True
    return False


@compiled_inline
def _place_m(
    plane: Row, chunk: np.uint64, index: int, j: int, half_width_m: float
) -> tuple[float, float]:
    """Centre of an obstacle, from the corner of its chunk.

    With open edges the whole obstacle lies between them: a place that is uniform over the width is
    mapped to one that is uniform over what fits.
    """
    bits = number(chunk, np.uint64(index) * BLOCK + PLACE)
    y_m = second_half(bits) * plane.chunk_width_m
    if plane.edges == OPEN:
        corner_m = j * plane.chunk_width_m
        fits = 1.0 - 2.0 * half_width_m / plane.width_m
        y_m = half_width_m + (corner_m + y_m) * fits - corner_m
    return first_half(bits) * CHUNK_M, y_m


@compiled_inner
def _form(shape: Row, bits: np.uint64) -> tuple[int, float]:
    """Corners and dent of a polygon, lobes and waviness of a curve."""
    dent = between(shape.dent_low, shape.dent_high, second_half(bits))
    if shape.kind == CURVE:
        return LOBES[0] + int((LOBES[1] + 1 - LOBES[0]) * first_half(bits)), dent
    span = shape.corners_high + 1 - shape.corners_low
    return shape.corners_low + int(span * first_half(bits)), dent
