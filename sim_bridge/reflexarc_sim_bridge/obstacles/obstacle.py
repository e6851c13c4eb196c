"""One obstacle in compiled code: its shape, its place, its corners and its colour."""

import math
from typing import NamedTuple

import numpy as np

from reflexarc_sim_bridge.arrays.layout import CURVE, NOTHING, POLYGON, WALL, Row
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import between, first_half, number, second_half
from reflexarc_sim_bridge.obstacles.keys import CORNERS, PAINT, PAINT_BLUE
from reflexarc_sim_bridge.worlds import outlines
from reflexarc_sim_bridge.worlds.outlines import CURVE_CORNERS

_FULL = 255.0
_S40 = np.uint64(40)
"""Leaves the 24 bits of a number that a float32 holds exactly."""
_CURVE_RAD = 2.0 * np.pi * np.arange(CURVE_CORNERS) / CURVE_CORNERS
_CURVE_COS, _CURVE_SIN = np.cos(_CURVE_RAD), np.sin(_CURVE_RAD)

polygon_angle_rad = compiled_inline(outlines.polygon_angle_rad)
polygon_share = compiled_inline(outlines.polygon_share)
wavy_share = compiled_inline(outlines.wavy_share)


class Obstacle(NamedTuple):
    """One obstacle. Its place is relative to the corner of its chunk."""

    kind: int
    """BOX, DISC and so on; NOTHING where none is drawn."""
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
    """Colour, 8 bits each of red, green and blue; of a striped one the number of its surface."""


@compiled_inline
def nothing() -> Obstacle:
    """A placeholder of kind NOTHING, which near lists skip."""
    return Obstacle(NOTHING, 0.0, 0.0, 0.0, 0.0, 0.0, 4, 0.0, np.uint64(0), 0)


@compiled_inner
def paint_of(layer: Row, key: np.uint64, block: np.uint64) -> int:
    """`Obstacle.paint` of the obstacle whose random numbers begin at `block`."""
    if layer.stripes_m > 0.0:
        return np.int64(number(key, block + PAINT) >> _S40)  # type: ignore[return-value]  # int, compiled
    return colour_of(layer, key, block, 1.0)


@compiled_inner
def colour_of(layer: Row, key: np.uint64, block: np.uint64, contrast: float) -> int:
    """A colour within the bounds of a layer: 8 bits each of red, green and blue.

    Args:
        layer: whose bounds.
        key: of the stream that it is drawn from.
        block: where in the stream.
        contrast: how far it lies from their middle, as a share of what was drawn.
    """
    bits = number(key, block + PAINT)
    draw_red = draw_green = draw_blue = first_half(bits)
    if layer.channels == 3:
        draw_green, draw_blue = second_half(bits), first_half(number(key, block + PAINT_BLUE))
    red = _shade(layer.red_low, layer.red_high, draw_red, contrast)
    green = _shade(layer.green_low, layer.green_high, draw_green, contrast)
    blue = _shade(layer.blue_low, layer.blue_high, draw_blue, contrast)
    return (red << 16) | (green << 8) | blue


@compiled_inline
def _shade(low: float, high: float, draw: float, contrast: float) -> int:
    """8 bits; at full contrast the draw itself, for no bit of its 32 is lost here."""
    return int(_FULL * between(low, high, 0.5 + contrast * (draw - 0.5)) + 0.5)


@compiled_inline
def corner_count(obstacle: Obstacle) -> int:
    """How many corners an outline has; the field holds the lobes of a curve."""
    return CURVE_CORNERS if obstacle.kind == CURVE else obstacle.corners


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
        jitter = first_half(number(key, obstacle.block + CORNERS + np.uint64(corner)))
        angle_rad = polygon_angle_rad(corner, obstacle.corners, jitter)
        radius_m = obstacle.half_length_m * polygon_share(corner, obstacle.dent)
        return radius_m * math.cos(angle_rad), radius_m * math.sin(angle_rad)
    right, upper = corner in (0, 3), corner in (0, 1)
    x_m = obstacle.half_length_m if right else -obstacle.half_length_m
    y_m = obstacle.half_width_m if upper else -obstacle.half_width_m
    if obstacle.kind == WALL:
        y_m += obstacle.dent if right else -obstacle.dent
    return x_m, y_m
