"""What an eye sees: each ray takes the first thing that it meets, and its shade.

Obstacles are the outer loop, four at a time, and the rays of a tile the inner one, without
branches: the compiler then treats 8 or 16 rays at once. Distances are float32, good to about a
micrometre within a field of metres; a step of the 8-bit nearness is 2 cm at 5 m.

The formulas of a ray's bearing and of its shade are `reflexarc_runtime.retina`'s, compiled: a
simulated eye and a real scan cannot differ.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_runtime import retina
from reflexarc_sim_bridge.compiled import compiled_inline, compiled_part
from reflexarc_sim_bridge.geometry import meets_box_m, meets_disc_m, meets_side_m, reciprocal
from reflexarc_sim_bridge.near import NOWHERE, place_in_layer_m
from reflexarc_sim_bridge.params import (
    BOXES,
    DISCS,
    SIDES,
    TILE_RAYS,
    EyeParams,
    Floats32,
    Params,
)
from reflexarc_sim_bridge.pick import judge_boxes, judge_discs, judge_sides, listed
from reflexarc_sim_bridge.workspace import Workspace

_STEEPEST = np.float32(1e-9)
_ZERO, _MINUS = np.float32(0.0), np.float32(-1.0)
_BYTE = 0xFF
_RED, _GREEN, _BLUE, _GREY = 299, 587, 114, 255_000.0
"""Shares of the colours in a grey value (ITU-R BT.601), in thousandths, and what white adds up to.
"""

brightness = compiled_inline(retina.brightness)
value = compiled_inline(retina.value)


@compiled_part
def look(params: Params, work: Workspace, i: int, eye_index: int) -> None:
    """Fill `work.distance_m` and `work.paint` with what each sub-ray of an agent's eye meets."""
    eye, agents = params.eye, params.agents
    state = agents.state[i]
    plane = params.world.planes[state.world]
    work.distance_m[:] = eye.range_m
    work.paint[:] = _MINUS
    cos, sin = np.float32(1.0), _ZERO
    if eye.turns:
        cos, sin = np.float32(math.cos(state.heading_rad)), np.float32(math.sin(state.heading_rad))
    _aim(eye, work, cos, sin)
    if state.is_inside:
        work.distance_m[:] = _ZERO
        work.paint[:] = 0xFFFFFF
        return
    side_m = -eye.half_baseline_m if eye_index else eye.half_baseline_m
    for number in range(plane.layers):
        layer = params.world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        x, y = np.float32(x_m - side_m * sin), np.float32(y_m + side_m * cos)
        counts = agents.near_counts[i, number]
        for first in range(0, work.distance_m.size, TILE_RAYS):
            if counts[BOXES]:
                _see_boxes(eye, work, agents.boxes[i, number], counts[BOXES], x, y, first)
            if counts[DISCS]:
                _see_discs(eye, work, agents.discs[i, number], counts[DISCS], x, y, first)
            if counts[SIDES]:
                _see_sides(eye, work, agents.sides[i, number], counts[SIDES], x, y, first)


@compiled_part
def shade_tiles(
    eye: EyeParams, work: Workspace, background: float, values: npt.NDArray[np.uint8]
) -> None:
    """Value of each ray of a grey eye without samples whose rays fill whole tiles: (rays,)."""
    for first in range(0, eye.rays, TILE_RAYS):
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        out, alive = values[first:], eye.alive[first:]
        for ray in range(TILE_RAYS):
            bright = _grey_brightness(eye, distance_m[ray], paint[ray], background)
            out[ray] = value(bright) if alive[ray] else 0


@compiled_part
def shade_rays(eye: EyeParams, work: Workspace, background: float, start: int) -> None:
    """Value of each ray from what its sub-rays met: `work.retina` from `start` on."""
    for ray in range(eye.rays):
        for channel in range(eye.channels):
            bright = 0.0
            for k in range(ray * eye.samples, (ray + 1) * eye.samples):
                bright += _brightness(eye, work.distance_m[k], work.paint[k], channel, background)
            at = start + ray * eye.channels + channel
            work.retina[at] = value(bright / eye.samples) if eye.alive[ray] else 0


@compiled_inline
def _brightness(
    eye: EyeParams, distance_m: np.float32, paint: np.float32, channel: int, background: float
) -> float:
    if eye.channels == 1:
        return _grey_brightness(eye, distance_m, paint, background)
    tint = ((int(paint) >> (16 - 8 * channel)) & _BYTE) / _BYTE
    bright = brightness(tint, np.float64(distance_m), eye.range_m, eye.nearness)
    return bright if paint >= _ZERO else background


@compiled_inline
def _grey_brightness(
    eye: EyeParams, distance_m: np.float32, paint: np.float32, background: float
) -> float:
    bits = np.int32(paint)
    red, green, blue = (bits >> 16) & _BYTE, (bits >> 8) & _BYTE, bits & _BYTE
    tint = (_RED * red + _GREEN * green + _BLUE * blue) / _GREY
    bright = brightness(tint, np.float64(distance_m), eye.range_m, eye.nearness)
    return bright if paint >= _ZERO else background


@compiled_inline
def _aim(eye: EyeParams, work: Workspace, cos: np.float32, sin: np.float32) -> None:
    """Directions of the rays in the world's frame."""
    for k in range(eye.ahead.size):
        ahead, left = eye.ahead[k] * cos - eye.left[k] * sin, eye.ahead[k] * sin + eye.left[k] * cos
        work.ahead[k], work.left[k] = ahead, left
        work.per_ahead[k] = reciprocal(ahead, _STEEPEST)
        work.per_left[k] = reciprocal(left, _STEEPEST)


@compiled_inline
def _wedge(
    eye: EyeParams, work: Workspace, first: int
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Directions of the rightmost and the leftmost ray; zeros where a wedge is no use."""
    if eye.tile_is_wide:
        return _ZERO, _ZERO, _ZERO, _ZERO
    last = first + TILE_RAYS - 1
    return work.ahead[last], work.left[last], work.ahead[first], work.left[first]


@compiled_part
def _see_boxes(
    eye: EyeParams,
    work: Workspace,
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    first: int,
) -> None:
    """Let a tile of rays meet the boxes of a near list."""
    range_m, wedge = np.float32(eye.range_m), _wedge(eye, work, first)
    judge_boxes(near, count, x, y, range_m, *wedge, work.judged)
    picked = work.picked
    end = listed(work.judged, count, near.shape[1] - NOWHERE, picked)
    distance_m, paint = work.distance_m[first:], work.paint[first:]
    per_ahead, per_left = work.per_ahead[first:], work.per_left[first:]
    for n in range(0, end, 4):
        ax, ay, al, aw, ap = _column5(near, picked[n], x, y)
        bx, by, bl, bw, bp = _column5(near, picked[n + 1], x, y)
        cx, cy, cl, cw, cp = _column5(near, picked[n + 2], x, y)
        dx, dy, dl, dw, dp = _column5(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            pa, pl, best, tint = per_ahead[ray], per_left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_box_m(ax, ay, al, aw, pa, pl), ap, best, tint)
            best, tint = _nearer(meets_box_m(bx, by, bl, bw, pa, pl), bp, best, tint)
            best, tint = _nearer(meets_box_m(cx, cy, cl, cw, pa, pl), cp, best, tint)
            best, tint = _nearer(meets_box_m(dx, dy, dl, dw, pa, pl), dp, best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_part
def _see_discs(
    eye: EyeParams,
    work: Workspace,
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    first: int,
) -> None:
    """The same for discs."""
    range_m, wedge = np.float32(eye.range_m), _wedge(eye, work, first)
    judge_discs(near, count, x, y, range_m, *wedge, work.judged)
    picked = work.picked
    end = listed(work.judged, count, near.shape[1] - NOWHERE, picked)
    distance_m, paint = work.distance_m[first:], work.paint[first:]
    ahead, left = work.ahead[first:], work.left[first:]
    for n in range(0, end, 4):
        ax, ay, ar, ap = _column4(near, picked[n], x, y)
        bx, by, br, bp = _column4(near, picked[n + 1], x, y)
        cx, cy, cr, cp = _column4(near, picked[n + 2], x, y)
        dx, dy, dr, dp = _column4(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_disc_m(ax, ay, ar, ra, rl), ap, best, tint)
            best, tint = _nearer(meets_disc_m(bx, by, br, ra, rl), bp, best, tint)
            best, tint = _nearer(meets_disc_m(cx, cy, cr, ra, rl), cp, best, tint)
            best, tint = _nearer(meets_disc_m(dx, dy, dr, ra, rl), dp, best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_part
def _see_sides(
    eye: EyeParams,
    work: Workspace,
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    first: int,
) -> None:
    """The same for sides of polygons."""
    range_m, wedge = np.float32(eye.range_m), _wedge(eye, work, first)
    judge_sides(near, count, x, y, range_m, *wedge, work.judged)
    picked = work.picked
    end = listed(work.judged, count, near.shape[1] - NOWHERE, picked)
    distance_m, paint = work.distance_m[first:], work.paint[first:]
    ahead, left = work.ahead[first:], work.left[first:]
    for n in range(0, end, 4):
        ax, ay, aa, al, ap = _column5(near, picked[n], x, y)
        bx, by, ba, bl, bp = _column5(near, picked[n + 1], x, y)
        cx, cy, ca, cl, cp = _column5(near, picked[n + 2], x, y)
        dx, dy, da, dl, dp = _column5(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_side_m(ax, ay, aa, al, ra, rl), ap, best, tint)
            best, tint = _nearer(meets_side_m(bx, by, ba, bl, ra, rl), bp, best, tint)
            best, tint = _nearer(meets_side_m(cx, cy, ca, cl, ra, rl), cp, best, tint)
            best, tint = _nearer(meets_side_m(dx, dy, da, dl, ra, rl), dp, best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_inline
def _nearer(
    met: np.float32, paint: np.float32, best: np.float32, tint: np.float32
) -> tuple[np.float32, np.float32]:
    return (met if met < best else best), (paint if met < best else tint)


@compiled_inline
def _column5(
    near: Floats32, k: int, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32, np.float32]:
    """A column of boxes or sides, seen from (x, y)."""
    return near[0, k] - x, near[1, k] - y, near[2, k], near[3, k], near[4, k]


@compiled_inline
def _column4(
    near: Floats32, k: int, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """A column of discs, seen from (x, y)."""
    return near[0, k] - x, near[1, k] - y, near[2, k], near[3, k]
