"""Ray casting: the distance and the colour of the first obstacle that each ray of an eye meets.

Obstacles are the outer loop, four at a time, and the rays of a tile the inner one, without
branches: the compiler then treats 16 rays at once. Upright boxes and discs have formulas of their
own; turned boxes and polygons are cut into faces (`face_casting.py`). Distances are float32, good
to about a micrometre within a field of metres; a step of the 8-bit nearness is 2 cm at 5 m.
"""

import math

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_PAINT,
    BOX_X,
    BOX_Y,
    BOXES,
    DISC_PAINT,
    DISC_RADIUS,
    DISC_X,
    DISC_Y,
    DISCS,
    SIDES,
    TILE_RAYS,
    TURNED,
    WHITE,
    EyeParams,
    Floats32,
    Params,
)
from reflexarc_sim_bridge.arrays.workspace import Picked, Workspace
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline, compiled_part
from reflexarc_sim_bridge.obstacles.geometry import meets_box_m, meets_disc_m
from reflexarc_sim_bridge.obstacles.near_lists import near_of, place_in_layer_m
from reflexarc_sim_bridge.vision.face_casting import list_sides, list_turned, see_faces
from reflexarc_sim_bridge.vision.ray_directions import aim
from reflexarc_sim_bridge.vision.stripe_casting import paint_stripes
from reflexarc_sim_bridge.vision.visible import (
    FOUR,
    View,
    copied,
    judge_boxes,
    judge_discs,
    listed,
)

_ZERO, _ONE, _NOTHING = np.float32(0.0), np.float32(1.0), np.float32(-1.0)
_WHITE = np.float32(WHITE)


@compiled_part
def look(params: Params, work: Workspace, i: int, eye_index: int) -> None:
    """Fill `work.distance_m` and `work.paint` with what each sub-ray of an agent's eye meets."""
    eye, agents = params.eye, params.agents
    state = agents.state[i]
    plane = params.world.planes[state.world]
    cos, sin = _ONE, _ZERO
    if eye.turns:
        cos, sin = np.float32(math.cos(state.heading_rad)), np.float32(math.sin(state.heading_rad))
        aim(eye, cos, sin, work.ahead, work.left, work.per_ahead, work.per_left)
    work.distance_m[:] = _ZERO if state.is_inside else eye.range_m
    work.paint[:] = _WHITE if state.is_inside else _NOTHING
    if state.is_inside:
        return
    side_m, faces = -eye.half_baseline_m if eye_index else eye.half_baseline_m, 0
    is_striped = False
    for number in range(plane.layers):
        layer = params.world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        view = _eye_view(eye, work, np.float32(x_m - side_m * sin), np.float32(y_m + side_m * cos))
        near = near_of(agents, i, number)
        is_striped |= layer.stripes_m > 0.0
        if near.counts[BOXES]:
            _see_boxes(eye, work, near.boxes, near.counts[BOXES], view)
        if near.counts[DISCS]:
            _see_discs(eye, work, near.discs, near.counts[DISCS], view)
        if near.counts[TURNED]:
            faces = list_turned(work, i, near.turned, near.counts[TURNED], view, faces)
        if near.counts[SIDES]:
            faces = list_sides(work, i, near.sides, near.counts[SIDES], view, faces)
    if faces:
        see_faces(eye, work, faces)
    if is_striped:
        paint_stripes(params, work, i, -side_m * float(sin), side_m * float(cos))


@compiled_inline
def _eye_view(eye: EyeParams, work: Workspace, x: np.float32, y: np.float32) -> View:
    """The view of an eye at (x, y), without a wedge if its rays span half a circle or more."""
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
def _see_boxes(eye: EyeParams, work: Workspace, near: Floats32, count: int, view: View) -> None:
    """Let all rays meet the boxes of a near list."""
    sieve, seen, x, y = work.sieve, near, view.x, view.y
    if work.distance_m.size > TILE_RAYS:
        judge_boxes(near, count, view, sieve.judged)
        count = copied(near, view, sieve.judged, count, work.seen)
        seen, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        judge_boxes(seen, count, _tile_view(eye, work, first, x, y), sieve.judged)
        end = listed(sieve.numbers, sieve.judged, count, sieve.picked)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        per_ahead, per_left = work.per_ahead[first:], work.per_left[first:]
        _meet_boxes(seen, sieve.picked, end, x, y, per_ahead, per_left, distance_m, paint)


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
        a = _box(near, picked[n], x, y)
        b = _box(near, picked[n + 1], x, y)
        c = _box(near, picked[n + 2], x, y)
        d = _box(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            pa, pl, best, tint = per_ahead[ray], per_left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_box_m(*a[1:], pa, pl), a[0], best, tint)
            best, tint = _nearer(meets_box_m(*b[1:], pa, pl), b[0], best, tint)
            best, tint = _nearer(meets_box_m(*c[1:], pa, pl), c[0], best, tint)
            best, tint = _nearer(meets_box_m(*d[1:], pa, pl), d[0], best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_part
def _see_discs(eye: EyeParams, work: Workspace, near: Floats32, count: int, view: View) -> None:
    """Let all rays meet the discs of a near list."""
    sieve, seen, x, y = work.sieve, near, view.x, view.y
    if work.distance_m.size > TILE_RAYS:
        judge_discs(near, count, view, sieve.judged)
        count = copied(near, view, sieve.judged, count, work.seen)
        seen, x, y = work.seen, _ZERO, _ZERO
    for first in range(0, work.distance_m.size, TILE_RAYS):
        judge_discs(seen, count, _tile_view(eye, work, first, x, y), sieve.judged)
        end = listed(sieve.numbers, sieve.judged, count, sieve.picked)
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        ahead, left = work.ahead[first:], work.left[first:]
        _meet_discs(seen, sieve.picked, end, x, y, ahead, left, distance_m, paint)


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
        a = _disc(near, picked[n], x, y)
        b = _disc(near, picked[n + 1], x, y)
        c = _disc(near, picked[n + 2], x, y)
        d = _disc(near, picked[n + 3], x, y)
        for ray in range(TILE_RAYS):
            ra, rl, best, tint = ahead[ray], left[ray], distance_m[ray], paint[ray]
            best, tint = _nearer(meets_disc_m(*a[1:], ra, rl), a[0], best, tint)
            best, tint = _nearer(meets_disc_m(*b[1:], ra, rl), b[0], best, tint)
            best, tint = _nearer(meets_disc_m(*c[1:], ra, rl), c[0], best, tint)
            best, tint = _nearer(meets_disc_m(*d[1:], ra, rl), d[0], best, tint)
            distance_m[ray], paint[ray] = best, tint


@compiled_inline
def _nearer(
    met: np.float32, paint: np.float32, best: np.float32, tint: np.float32
) -> tuple[np.float32, np.float32]:
    return (met if met < best else best), (paint if met < best else tint)


@compiled_inline
def _disc(
    near: Floats32, k: np.uint32, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32]:
    """Colour of a disc, its place relative to (x, y), and its radius."""
    return near[DISC_PAINT, k], near[DISC_X, k] - x, near[DISC_Y, k] - y, near[DISC_RADIUS, k]


@compiled_inline
def _box(
    near: Floats32, k: np.uint32, x: np.float32, y: np.float32
) -> tuple[np.float32, np.float32, np.float32, np.float32, np.float32]:
    """Colour of an upright box, its place relative to (x, y), and half its sides."""
    dx, dy = near[BOX_X, k] - x, near[BOX_Y, k] - y
    return near[BOX_PAINT, k], dx, dy, near[BOX_HALF_LENGTH, k], near[BOX_HALF_WIDTH, k]
