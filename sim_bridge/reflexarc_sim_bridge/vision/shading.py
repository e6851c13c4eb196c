"""Values of an eye's rays, from the distance and the colour that its sub-rays met.

The formula is `reflexarc_runtime.sensing.ray_values`'s, compiled; the share of the range that it
takes is made without a division, to the same bit (`quotient`). A simulated eye and a real scan
cannot differ.

A division takes a processor many times as long as a multiplication. With y the float64 nearest to
1 / b, q = a·y is less than two units in its last place off. What a − q·b leaves takes it to the
float64 nearest to a / b or to the one beside it, and once more to the nearest (Markstein,
"Computation of elementary functions on the IBM RISC System/6000 processor", IBM J. R&D, 1990).
"""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.sensing import ray_values
from reflexarc_sim_bridge.arrays.layout import TILE_RAYS, EyeParams, Floats32
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline, compiled_part
from reflexarc_sim_bridge.native.intrinsics import multiply_add

_ZERO = np.float32(0.0)
_BYTE, _FULL = 0xFF, 255.0
_RED, _GREEN, _BLUE, _GREY = 299.0, 587.0, 114.0, 255_000.0
"""Shares of the colours in a grey value (ITU-R BT.601), in thousandths, and what white adds up to.
"""
_PER_FULL, _PER_GREY = 1.0 / _FULL, 1.0 / _GREY

brightness = compiled_inline(ray_values.brightness)
value = compiled_inline(ray_values.value)


@compiled_part
def shade_tiles(
    eye: EyeParams, work: Workspace, background: float, values: npt.NDArray[np.uint8]
) -> None:
    """Value of each ray of a grey eye that blends nothing, whose rays fill whole tiles: (rays,)."""
    for first in range(0, eye.rays, TILE_RAYS):
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        _shade_tile(eye, distance_m, paint, eye.alive[first:], background, values[first:])


@compiled_disjoint
def _shade_tile(
    eye: EyeParams,
    distance_m: Floats32,
    paint: Floats32,
    alive: npt.NDArray[np.bool_],
    background: float,
    values: npt.NDArray[np.uint8],
) -> None:
    per_range = 1.0 / eye.range_m
    for ray in range(TILE_RAYS):
        bright = _grey_brightness(eye, per_range, distance_m[ray], paint[ray], background)
        values[ray] = value(bright) if alive[ray] else 0


@compiled_part
def shade_rays(
    eye: EyeParams, work: Workspace, background: float, values: npt.NDArray[np.uint8], start: int
) -> None:
    """Value of each ray from what its sub-rays met, or from what was kept of them."""
    bright = work.bright[: eye.rays * eye.blended]
    for channel in range(eye.channels):
        _shade_subrays(eye, work.distance_m, work.paint, channel, background, bright)
        _add_up(eye.rays, eye.blended, bright, work.total)
        _round(eye.alive, eye.blended, eye.channels, work.total, values, start + channel)


@compiled_disjoint
def keep_nearest(rays: int, samples: int, distance_m: Floats32, paint: Floats32) -> None:
    """Of each ray's sub-rays keep what the nearest met: in front of the arrays, one a ray."""
    for ray in range(rays):
        first = ray * samples
        nearest_m, tint = distance_m[first], paint[first]
        for k in range(first + 1, first + samples):
            met_m = distance_m[k]
            tint = paint[k] if met_m < nearest_m else tint
            nearest_m = met_m if met_m < nearest_m else nearest_m
        distance_m[ray], paint[ray] = nearest_m, tint


@compiled_disjoint
def _add_up(
    rays: int, samples: int, bright: npt.NDArray[np.float64], total: npt.NDArray[np.float64]
) -> None:
    """Sum of the sub-rays of each ray."""
    total[:] = 0.0
    for sample in range(samples):
        for ray in range(rays):
            total[ray] += bright[np.uintp(ray * samples + sample)]


@compiled_disjoint
def _round(
    alive: npt.NDArray[np.bool_],
    samples: int,
    channels: int,
    total: npt.NDArray[np.float64],
    values: npt.NDArray[np.uint8],
    start: int,
) -> None:
    for ray in range(total.size):
        at = np.uintp(start + ray * channels)
        values[at] = value(total[ray] / samples) if alive[ray] else 0


@compiled_disjoint
def _shade_subrays(
    eye: EyeParams,
    distance_m: Floats32,
    paint: Floats32,
    channel: int,
    background: float,
    bright: npt.NDArray[np.float64],
) -> None:
    per_range = 1.0 / eye.range_m
    if eye.channels == 1:
        for k in range(bright.size):
            bright[k] = _grey_brightness(eye, per_range, distance_m[k], paint[k], background)
        return
    shift = 16 - 8 * channel
    for k in range(bright.size):
        byte = np.float64((np.int32(paint[k]) >> shift) & _BYTE)
        tint = quotient(byte, _FULL, _PER_FULL)
        share = quotient(np.float64(distance_m[k]), eye.range_m, per_range)
        shade = brightness(tint, share, eye.nearness)
        bright[k] = shade if paint[k] >= _ZERO else background


@compiled_inline
def _grey_brightness(
    eye: EyeParams,
    per_range: float,
    distance_m: np.float32,
    paint: np.float32,
    background: float,
) -> float:
    bits = np.int32(paint)
    red, green = np.int32((bits >> 16) & _BYTE), np.int32((bits >> 8) & _BYTE)
    white = _RED * red + _GREEN * green + _BLUE * np.int32(bits & _BYTE)
    tint = quotient(white, _GREY, _PER_GREY)
    share = quotient(np.float64(distance_m), eye.range_m, per_range)
    bright = brightness(tint, share, eye.nearness)
    return bright if paint >= _ZERO else background


@compiled_inline
def quotient(a: float, b: float, per_b: float) -> float:
    """The float64 nearest to a / b.

    Args:
        a: finite, and not so small or large that a product with it leaves the normal numbers.
        b: the same, not 0.
        per_b: 1 / b.
    """
    near: float = a * per_b
    nearer: float = multiply_add(multiply_add(-near, b, a), per_b, near)
    nearest: float = multiply_add(multiply_add(-nearer, b, a), per_b, nearer)
    return nearest
