"""The endless generator: which obstacles there are, for ever, without remembering one.

A chunk is a rectangle of the plane, CHUNK_M along x. Its obstacles follow from (generator version,
seed, stream, layer, chunk i, chunk j) alone, so chunks can be asked for in any order, as often as
one likes, on any number of threads. Across a periodic world chunk j is chunk j modulo their
number. An obstacle belongs to the chunk of its centre; walls are cut at the borders of chunks.

    scatter     a Poisson count, then for each obstacle a block of random numbers
    others      see `structures.py`
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    CURVE,
    DISC,
    NOTHING,
    OPEN,
    POLYGON,
    WALL,
    Row,
    Table,
)
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import (
    between,
    first_half,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.keys import chunk_key, column_key
from reflexarc_sim_bridge.worlds import outlines
from reflexarc_sim_bridge.worlds.layers import CHUNK_M
from reflexarc_sim_bridge.worlds.outlines import CURVE_CORNERS
from reflexarc_sim_bridge.worlds.shapes import LOBES

# Number 0 of a chunk is its count; obstacle j has the numbers 1 + 64j to 64 + 64j.
BLOCK = np.uint64(64)
PLACE, _SIZE, _KIND, _OUTLINE, _PAINT, _PAINT_BLUE, _MARK, _CORNERS = (
    np.uint64(k) for k in (1, 2, 3, 4, 5, 6, 7, 8)
)
_NEIGHBOURS = 9
_FULL = 255.0
_WHITE = 0xFFFFFF

_CURVE_RAD = 2.0 * np.pi * np.arange(CURVE_CORNERS) / CURVE_CORNERS
_CURVE_COS, _CURVE_SIN = np.cos(_CURVE_RAD), np.sin(_CURVE_RAD)

polygon_angle_rad = compiled_inline(outlines.polygon_angle_rad)
polygon_share = compiled_inline(outlines.polygon_share)
wavy_share = compiled_inline(outlines.wavy_share)


class Obstacle(NamedTuple):
    """One obstacle, in compiled code. Its place is relative to the corner of its chunk."""

    kind: int
    x_m: float
    y_m: float
    half_length_m: float
    """Half the side along x, or the radius."""
    half_width_m: float
    """Half the side along y, or the radius; of a wall half of its thickness."""
    turned_rad: float
    corners: int
    dent: float
    """Dent of a polygon, waviness of a curve, half the rise of a wall's piece."""
    block: np.uint64
    """Where its random numbers begin."""
    paint: int
    """Colour, 8 bits each of red, green and blue."""


@compiled_inline
def scatter_count(layer: Row, counts: npt.NDArray[np.float64], chunk: np.uint64, i: int) -> int:
    """How many obstacles of a scatter layer a chunk has.

    The Poisson draw is inverted: as many as there are counts whose probability it has passed. All
    are compared, for no branch foresees where to stop.

    Args:
        layer: row of `LAYER_DTYPE`.
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
def scatter_place_m(
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


@compiled_inline
def scattered(
    plane: Row, layer: Row, shapes: Table, chunk: np.uint64, j: int, index: int
) -> Obstacle:
    """Obstacle `index` of a chunk of a scatter layer, before any thinning.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of `LAYER_DTYPE`.
        shapes: rows of `SHAPE_DTYPE`: (shapes,).
        chunk: key of the chunk.
        j: the chunk, along y.
        index: which of its obstacles.
    """
    block = np.uint64(index) * BLOCK
    which, turn = 0, 0.0
    if layer.is_plain == 0:
        bits = number(chunk, block + _KIND)
        turn, drawn = second_half(bits), first_half(bits)
        while which < layer.shapes - 1 and drawn >= shapes[which].share_up_to:
            which += 1
    shape = shapes[which]
    size = number(chunk, block + _SIZE)
    across = between(shape.size_low, shape.size_high, first_half(size))
    kind, corners, dent = shape.kind, 4, 0.0
    half_length_m, half_width_m = across, across
    if kind in (POLYGON, CURVE):
        corners, dent = _form(shape, number(chunk, block + _OUTLINE))
    elif kind != DISC:
        half_width_m = 0.5 * across
        half_length_m = 0.5 * between(shape.length_low, shape.length_high, second_half(size))
    x_m, y_m = scatter_place_m(plane, chunk, index, j, half_width_m)
    turned_rad = between(shape.turned_low, shape.turned_high, turn)
    paint = _WHITE if layer.is_white else paint_of(layer, chunk, block)
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
    mark = number(chunk, np.uint64(index) * BLOCK + _MARK)
    x_m, y_m = scatter_place_m(plane, chunk, index, j, 0.0)
    for neighbour in range(_NEIGHBOURS):
        di, dj = neighbour // 3 - 1, neighbour % 3 - 1
        other = chunk_key(column_key(key, i + di), j + dj, plane.across)
        for k in range(scatter_count(layer, counts, other, i + di)):
            if number(other, np.uint64(k) * BLOCK + _MARK) < mark:
                other_x_m, other_y_m = scatter_place_m(plane, other, k, j + dj, 0.0)
                dx_m = other_x_m + di * CHUNK_M - x_m
                dy_m = other_y_m + dj * plane.chunk_width_m - y_m
                if dx_m * dx_m + dy_m * dy_m < layer.gap_m * layer.gap_m:
                    return True
    return False


@compiled_inner
def paint_of(layer: Row, key: np.uint64, block: np.uint64) -> int:
    """Colour of an obstacle: 8 bits each of red, green and blue."""
    bits = number(key, block + _PAINT)
    draw_red = draw_green = draw_blue = first_half(bits)
    if layer.channels == 3:
        draw_green, draw_blue = second_half(bits), first_half(number(key, block + _PAINT_BLUE))
    red = int(_FULL * between(layer.red_low, layer.red_high, draw_red) + 0.5)
    green = int(_FULL * between(layer.green_low, layer.green_high, draw_green) + 0.5)
    blue = int(_FULL * between(layer.blue_low, layer.blue_high, draw_blue) + 0.5)
    return (red << 16) | (green << 8) | blue


@compiled_inline
def corner_m(
    key: np.uint64, obstacle: Obstacle, corner: int, cos: float, sin: float
) -> tuple[float, float]:
    """A corner of an outline, relative to its centre; counter-clockwise.

    Args:
        key: the chunk's.
        obstacle: whose.
        corner: which.
        cos: of the angle by which the obstacle is turned; the same for all of its corners.
        sin: the same.
    """
    x_m, y_m = _upright_corner_m(key, obstacle, corner)
    return x_m * cos - y_m * sin, x_m * sin + y_m * cos


@compiled_inner
def _upright_corner_m(key: np.uint64, obstacle: Obstacle, corner: int) -> tuple[float, float]:
    """A corner before the obstacle is turned. See `outlines`."""
    if obstacle.kind == CURVE:
        lobe = obstacle.corners * corner % CURVE_CORNERS
        radius_m = obstacle.half_length_m * wavy_share(_CURVE_COS[lobe], obstacle.dent)
        return radius_m * _CURVE_COS[corner], radius_m * _CURVE_SIN[corner]
    if obstacle.kind == POLYGON:
        jitter = first_half(number(key, obstacle.block + _CORNERS + np.uint64(corner)))
        angle_rad = polygon_angle_rad(corner, obstacle.corners, jitter)
        radius_m = obstacle.half_length_m * polygon_share(corner, obstacle.dent)
        return radius_m * math.cos(angle_rad), radius_m * math.sin(angle_rad)
    right, upper = corner in (0, 3), corner in (0, 1)
    x_m = obstacle.half_length_m if right else -obstacle.half_length_m
    y_m = obstacle.half_width_m if upper else -obstacle.half_width_m
    if obstacle.kind == WALL:
        y_m += obstacle.dent if right else -obstacle.dent
    return x_m, y_m


@compiled_inline
def corner_count(obstacle: Obstacle) -> int:
    """How many corners an outline has; the field holds the lobes of a curve."""
    return CURVE_CORNERS if obstacle.kind == CURVE else obstacle.corners


@compiled_inline
def nothing() -> Obstacle:
    """An obstacle that is none."""
    return Obstacle(NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, 4, 0.0, np.uint64(0), 0)


@compiled_inner
def _form(shape: Row, bits: np.uint64) -> tuple[int, float]:
    """Corners and dent of a polygon, lobes and waviness of a curve."""
    dent = between(shape.dent_low, shape.dent_high, second_half(bits))
    if shape.kind == CURVE:
        return LOBES[0] + int((LOBES[1] + 1 - LOBES[0]) * first_half(bits)), dent
    span = shape.corners_high + 1 - shape.corners_low
    return shape.corners_low + int(span * first_half(bits)), dent
