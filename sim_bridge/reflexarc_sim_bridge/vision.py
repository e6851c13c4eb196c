"""What an eye sees: each ray takes the first thing that it meets, and its shade.

Obstacles are the outer loop, four at a time, and the rays of a tile the inner one, without
branches: the compiler then treats 8 or 16 rays at once. Distances are float32, good to about a
micrometre within a field of metres; a step of the 8-bit nearness is 2 cm at 5 m.

The formulas of a ray's bearing and of its shade are `reflexarc_runtime.retina`'s, compiled: a
simulated eye and a real scan cannot differ.
"""

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime import retina
from reflexarc_sim_bridge.aim import aim
from reflexarc_sim_bridge.compiled import (
    compiled_disjoint,
    compiled_inline,
    compiled_part,
)
from reflexarc_sim_bridge.geometry import (
    meets_box_m,
    meets_disc_m,
    meets_side_m,
    meets_turned_box,
    sooner,
)
from reflexarc_sim_bridge.near import near_of, place_in_layer_m
from reflexarc_sim_bridge.params import (
    BOXES,
    DISCS,
    SIDES,
    TILE_RAYS,
    TURNED,
    EyeParams,
    Floats32,
    Params,
)
from reflexarc_sim_bridge.pick import (
    FOUR,
    Picked,
    View,
    copied,
    pick_boxes,
    pick_discs,
    pick_sides,
    pick_turned,
)
from reflexarc_sim_bridge.workspace import Workspace

_ZERO, _MINUS = np.float32(0.0), np.float32(-1.0)
_BYTE, _FULL = 0xFF, 255.0
_RED, _GREEN, _BLUE, _GREY = 299.0, 587.0, 114.0, 255_000.0
"""Shares of the colours in a grey value (ITU-R BT.601), in thousandths, and what white adds up to.
"""

Column7: TypeAlias = tuple[
    np.float32, np.float32, np.float32, np.float32, np.float32, np.float32, np.float32
]

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
        aim(eye, cos, sin, work.ahead, work.left, work.per_ahead, work.per_left)
    if state.is_inside:
        work.distance_m[:] = _ZERO
        work.paint[:] = 0xFFFFFF
        return
    side_m = -eye.half_baseline_m if eye_index else eye.half_baseline_m
    for number in range(plane.layers):
        layer = params.world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        x, y = np.float32(x_m - side_m * sin), np.float32(y_m + side_m * cos)
        near = near_of(agents, i, number)
        if near.counts[BOXES]:
            _see_boxes(eye, work, near.boxes, near.counts[BOXES], x, y)
        if near.counts[TURNED]:
            _see_turned(eye, work, near.turned, near.counts[TURNED], x, y)
        if near.counts[DISCS]:
            _see_discs(eye, work, near.discs, near.counts[DISCS], x, y)
        if near.counts[SIDES]:
            _see_sides(eye, work, near.sides, near.counts[SIDES], x, y)


@compiled_part
def shade_tiles(
    eye: EyeParams, work: Workspace, background: float, values: npt.NDArray[np.uint8]
) -> None:
    """Value of each ray of a grey eye without samples whose rays fill whole tiles: (rays,)."""
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
    for ray in range(TILE_RAYS):
        bright = _grey_brightness(eye, distance_m[ray], paint[ray], background)
        values[ray] = value(bright) if alive[ray] else 0


@compiled_part
def shade_rays(eye: EyeParams, work: Workspace, background: float, start: int) -> None:
    """Value of each ray from what its sub-rays met: `work.retina` from `start` on."""
    bright, samples = work.bright, eye.samples
    for channel in range(eye.channels):
        _shade_subrays(eye, work.distance_m, work.paint, channel, background, bright)
        for ray in range(eye.rays):
            total = 0.0
            for k in range(ray * samples, (ray + 1) * samples):
                total += bright[k]
            at = start + ray * eye.channels + channel
            work.retina[at] = value(total / samples) if eye.alive[ray] else 0


@compiled_disjoint
def _shade_subrays(
    eye: EyeParams,
    distance_m: Floats32,
    paint: Floats32,
    channel: int,
    background: float,
    bright: npt.NDArray[np.float64],
) -> None:
    if eye.channels == 1:
        for k in range(bright.size):
            bright[k] = _grey_brightness(eye, distance_m[k], paint[k], background)
        return
    shift = 16 - 8 * channel
    for k in range(bright.size):
        tint = np.int32((np.int32(paint[k]) >> shift) & _BYTE) / _FULL
        shade = brightness(tint, np.float64(distance_m[k]), eye.range_m, eye.nearness)
        bright[k] = shade if paint[k] >= _ZERO else background


@compiled_inline
def _grey_brightness(
    eye: EyeParams, distance_m: np.float32, paint: np.float32, background: float
) -> float:
    bits = np.int32(paint)
    red, green = np.int32((bits >> 16) & _BYTE), np.int32((bits >> 8) & _BYTE)
    tint = (_RED * red + _GREEN * green + _BLUE * np.int32(bits & _BYTE)) / _GREY
    bright = brightness(tint, np.float64(distance_m), eye.range_m, eye.nearness)
    return bright if paint >= _ZERO else background


@compiled_inline
def _eye_view(eye: EyeParams, work: Workspace, x: np.float32, y: np.float32) -> View:
    """All that an eye at (x, y) can see; no wedge where one is no use."""
    range_m, last = np.float32(eye.range_m), work.ahead.size - 1
    if eye.is_wide:
        return View(x, y, range_m, _ZERO, _ZERO, _ZERO, _ZERO)
    return View(x, y, range_m, work.ahead[last], work.left[last], work.ahead[0], work.left[0])


@compiled_inline
def _tile_view(eye: EyeParams, work: Workspace, first: int, x: np.float32, y: np.float32) -> View:
    """The same of a tile of rays."""
    range_m, last = np.float32(eye.range_m), first + TILE_RAYS - 1
    if eye.tile_is_wide:
        return View(x, y, range_m, _ZERO, _ZERO, _ZERO, _ZERO)
    return View(
        x, y, range_m, work.ahead[last], work.left[last], work.ahead[first], work.left[first]
    )


@compiled_part
def _see_boxes(
    eye: EyeParams, work: Workspace, near: Floats32, count: int, x: np.float32, y: np.float32
) -> None:
    """Let all rays meet the boxes of a near list."""
    sieve = work.sieve
    if work.distance_m.size > TILE_RAYS:
        pick_boxes(near, count, _eye_view(eye, work, x, y), sieve)
        count = copied(near, x, y, sieve.judged, count, work.seen)
        near, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        view = _tile_view(eye, work, first, x, y)
        end = pick_boxes(near, count, view, sieve)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        per_ahead, per_left = work.per_ahead[first:], work.per_left[first:]
        _meet_boxes(near, sieve.picked, end, x, y, per_ahead, per_left, distance_m, paint)


@compiled_disjoint
def _meet_boxes(
    near: Floats32,
    picked: Picked,
    end: int,
    x: np.float32,
    y: np.float32,
    per_ahead: Floats32,
    per_left: Floats32,
    distance_m: Floats32,
    paint: Floats32,
) -> None:
    """Let a tile of rays meet boxes, four at a time."""
    for n in range(0, end, FOUR):
        a = _column5(near, picked[n], x, y)
        b = _column5(near, picked[n + 1], x, y)
        c = _column5(near, picked[n + 2], x, y)
        d = _column5(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            pa, pl, best, tint = per_ahead[ray], per_left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_box_m(*a[1:], pa, pl), a[0], best, tint)
            best, tint = _nearer(meets_box_m(*b[1:], pa, pl), b[0], best, tint)
            best, tint = _nearer(meets_box_m(*c[1:], pa, pl), c[0], best, tint)
            best, tint = _nearer(meets_box_m(*d[1:], pa, pl), d[0], best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_part
def _see_turned(
    eye: EyeParams, work: Workspace, near: Floats32, count: int, x: np.float32, y: np.float32
) -> None:
    """Let all rays meet the turned boxes of a near list."""
    sieve = work.sieve
    if work.distance_m.size > TILE_RAYS:
        pick_turned(near, count, _eye_view(eye, work, x, y), sieve)
        count = copied(near, x, y, sieve.judged, count, work.seen)
        near, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        view = _tile_view(eye, work, first, x, y)
        end = pick_turned(near, count, view, sieve)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        ahead, left = work.ahead[first:], work.left[first:]
        _meet_turned(near, sieve.picked, end, x, y, ahead, left, distance_m, paint)


@compiled_disjoint
def _meet_turned(
    near: Floats32,
    picked: Picked,
    end: int,
    x: np.float32,
    y: np.float32,
    ahead: Floats32,
    left: Floats32,
    distance_m: Floats32,
    paint: Floats32,
) -> None:
    """Let a tile of rays meet turned boxes, four at a time."""
    for n in range(0, end, FOUR):
        a = _column7(near, picked[n], x, y)
        b = _column7(near, picked[n + 1], x, y)
        c = _column7(near, picked[n + 2], x, y)
        d = _column7(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            ab = sooner(*_met_turned(a, ra, rl), *_met_turned(b, ra, rl))
            cd = sooner(*_met_turned(c, ra, rl), *_met_turned(d, ra, rl))
            length, per, mark = sooner(*ab, *cd)
            distance_m[ray], paint[ray] = _nearer(length / per, mark, best, tint)


@compiled_inline
def _met_turned(
    box: Column7, ahead: np.float32, left: np.float32
) -> tuple[np.float32, np.float32, np.float32]:
    """Length up to a turned box, as a fraction, and its paint."""
    length, per = meets_turned_box(*box[1:], ahead, left)
    return length, per, box[0]


@compiled_part
def _see_discs(
    eye: EyeParams, work: Workspace, near: Floats32, count: int, x: np.float32, y: np.float32
) -> None:
    """Let all rays meet the discs of a near list."""
    sieve = work.sieve
    if work.distance_m.size > TILE_RAYS:
        pick_discs(near, count, _eye_view(eye, work, x, y), sieve)
        count = copied(near, x, y, sieve.judged, count, work.seen)
        near, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        view = _tile_view(eye, work, first, x, y)
        end = pick_discs(near, count, view, sieve)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        ahead, left = work.ahead[first:], work.left[first:]
        _meet_discs(near, sieve.picked, end, x, y, ahead, left, distance_m, paint)


@compiled_disjoint
def _meet_discs(
    near: Floats32,
    picked: Picked,
    end: int,
    x: np.float32,
    y: np.float32,
    ahead: Floats32,
    left: Floats32,
    distance_m: Floats32,
    paint: Floats32,
) -> None:
    """Let a tile of rays meet discs, four at a time."""
    for n in range(0, end, FOUR):
        a = _column4(near, picked[n], x, y)
        b = _column4(near, picked[n + 1], x, y)
        c = _column4(near, picked[n + 2], x, y)
        d = _column4(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_disc_m(*a[1:], ra, rl), a[0], best, tint)
            best, tint = _nearer(meets_disc_m(*b[1:], ra, rl), b[0], best, tint)
            best, tint = _nearer(meets_disc_m(*c[1:], ra, rl), c[0], best, tint)
            best, tint = _nearer(meets_disc_m(*d[1:], ra, rl), d[0], best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_part
def _see_sides(
    eye: EyeParams, work: Workspace, near: Floats32, count: int, x: np.float32, y: np.float32
) -> None:
    """Let all rays meet the sides of a near list."""
    sieve = work.sieve
    if work.distance_m.size > TILE_RAYS:
        pick_sides(near, count, _eye_view(eye, work, x, y), sieve)
        count = copied(near, x, y, sieve.judged, count, work.seen)
        near, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        view = _tile_view(eye, work, first, x, y)
        end = pick_sides(near, count, view, sieve)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        ahead, left = work.ahead[first:], work.left[first:]
        _meet_sides(near, sieve.picked, end, x, y, ahead, left, distance_m, paint)


@compiled_disjoint
def _meet_sides(
    near: Floats32,
    picked: Picked,
    end: int,
    x: np.float32,
    y: np.float32,
    ahead: Floats32,
    left: Floats32,
    distance_m: Floats32,
    paint: Floats32,
) -> None:
    """Let a tile of rays meet sides, four at a time."""
    for n in range(0, end, FOUR):
        a = _column5(near, picked[n], x, y)
        b = _column5(near, picked[n + 1], x, y)
        c = _column5(near, picked[n + 2], x, y)
        d = _column5(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_side_m(*a[1:], ra, rl), a[0], best, tint)
            best, tint = _nearer(meets_side_m(*b[1:], ra, rl), b[0], best, tint)
            best, tint = _nearer(meets_side_m(*c[1:], ra, rl), c[0], best, tint)
            best, tint = _nearer(meets_side_m(*d[1:], ra, rl), d[0], best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_inline
def _nearer(
    met: np.float32, paint: np.float32, best: np.float32, tint: np.float32
) -> tuple[np.float32, np.float32]:
    return (met if met < best else best), (paint if met < best else tint)


@compiled_inline
def _column4(
    near: Floats32, k: np.uint32, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Paint of a disc, and itself seen from (x, y)."""
    return near[3, k], near[0, k] - x, near[1, k] - y, near[2, k]


@compiled_inline
def _column5(
    near: Floats32, k: np.uint32, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32, np.float32]:
    """The same of an upright box, or of a side."""
    return near[4, k], near[0, k] - x, near[1, k] - y, near[2, k], near[3, k]


@compiled_inline
def _column7(near: Floats32, k: np.uint32, x: np.float32, y: np.float32) -> Column7:
    """The same of a turned box."""
    dx, dy = near[0, k] - x, near[1, k] - y
    return near[4, k], dx, dy, near[2, k], near[3, k], near[5, k], near[6, k]
