"""What an eye sees: each ray takes the first thing that it meets.

Obstacles are the outer loop, four at a time, and the rays of a tile the inner one, without
branches: the compiler then treats 16 rays at once. Upright boxes and discs are met as they are;
what has faces in any direction, turned boxes and polygons, as faces (`faces.py`), all layers'
together. Distances are float32, good to about a micrometre within a field of metres; a step of the
8-bit nearness is 2 cm at 5 m.
"""

import math

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_PAINT,
    BOXES,
    DISCS,
    FACES,
    SIDES,
    TILE_RAYS,
    TURNED,
    EyeParams,
    Floats32,
    Params,
)
from reflexarc_sim_bridge.arrays.workspace import Faces, Judged, Picked, Workspace
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline, compiled_part
from reflexarc_sim_bridge.native.intrinsics import LANES
from reflexarc_sim_bridge.obstacles.geometry import meets_box_m, meets_disc_m
from reflexarc_sim_bridge.obstacles.near_lists import near_of, note_loss, place_in_layer_m
from reflexarc_sim_bridge.vision.faces import (
    face,
    faces_of_boxes,
    faces_of_sides,
    fill_up,
    judge_faces,
    met_per_m,
)
from reflexarc_sim_bridge.vision.ray_directions import aim
from reflexarc_sim_bridge.vision.visible import (
    FOUR,
    View,
    copied,
    judge_boxes,
    judge_discs,
    judge_sides,
    judge_turned,
    listed,
)

_ZERO, _ONE, _NOTHING = np.float32(0.0), np.float32(1.0), np.float32(-1.0)
_WHITE = np.float32(0xFFFFFF)


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
    for number in range(plane.layers):
        layer = params.world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        view = _eye_view(eye, work, np.float32(x_m - side_m * sin), np.float32(y_m + side_m * cos))
        near = near_of(agents, i, number)
        if near.counts[BOXES]:
            _see_boxes(eye, work, near.boxes, near.counts[BOXES], view)
        if near.counts[DISCS]:
            _see_discs(eye, work, near.discs, near.counts[DISCS], view)
        if near.counts[TURNED]:
            faces = _list_turned(work, i, near.turned, near.counts[TURNED], view, faces)
        if near.counts[SIDES]:
            faces = _list_sides(work, i, near.sides, near.counts[SIDES], view, faces)
    if faces:
        _see_faces(eye, work, faces)


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
def _list_turned(
    work: Workspace, i: int, near: Floats32, count: int, view: View, first: int
) -> int:
    """List the turned boxes that agent i's eye can see as faces from `first` on; where they end."""
    judged, seen = work.sieve.judged, work.seen
    judge_turned(near, count, view, judged)
    n = _fitting(work, i, copied(near, view, judged, count, seen), first)
    if faces_of_boxes(seen, n, work.faces, first, judged):
        work.distance_m[:] = _ZERO
        work.paint[:] = seen[BOX_PAINT, _first_of(judged)]
    return first + n


@compiled_inline
def _first_of(marked: Judged) -> int:
    k = 0
    while not marked[k]:
        k += 1
    return k


@compiled_part
def _list_sides(work: Workspace, i: int, near: Floats32, count: int, view: View, first: int) -> int:
    """The same of sides of polygons."""
    judge_sides(near, count, view, work.sieve.judged)
    n = _fitting(work, i, copied(near, view, work.sieve.judged, count, work.seen), first)
    faces_of_sides(work.seen, n, work.faces, first)
    return first + n


@compiled_inline
def _fitting(work: Workspace, i: int, count: int, first: int) -> int:
    """How many of these faces there is room for from `first` on; counts those that there is not."""
    room = work.faces.paint.size - LANES - first
    if count > room:
        note_loss(work.losses, i, FACES, count - room)
        return room
    return count


@compiled_part
def _see_faces(eye: EyeParams, work: Workspace, count: int) -> None:
    """Let all rays meet the faces that are listed."""
    sieve, tiles = work.sieve, work.distance_m.size // TILE_RAYS
    fill_up(work.faces, count)
    for tile in range(tiles):
        ahead, left = work.ahead[tile * TILE_RAYS :], work.left[tile * TILE_RAYS :]
        if tiles == 1 or eye.tile_is_wide:
            work.ends[tile] = count
        else:
            judge_faces(work.faces, count, ahead, left, sieve.judged)
            work.ends[tile] = listed(sieve.numbers, sieve.judged, count, work.lists[tile])
    for tile in range(tiles):
        first = tile * TILE_RAYS
        ahead, left = work.ahead[first:], work.left[first:]
        distance_m, paint = work.distance_m[first:], work.paint[first:]
        picked, end = work.lists[tile], work.ends[tile]
        _meet_faces(work.faces, picked, end, ahead, left, work.per_m, distance_m, paint)


@compiled_disjoint
def _meet_faces(
    faces: Faces,
    picked: Picked,
    end: int,
    ahead: Floats32,
    left: Floats32,
    per_m: Floats32,
    distance_m: Floats32,
    paint: Floats32,
) -> None:
    """Let a tile of rays meet faces, four at a time; `per_m` is scratch: (TILE_RAYS,)."""
    for ray in range(per_m.size):
        per_m[ray] = _ONE / distance_m[ray]
    for n in range(0, end, FOUR):
        a, b = face(faces, picked[n]), face(faces, picked[n + 1])
        c, d = face(faces, picked[n + 2]), face(faces, picked[n + 3])
        for ray in range(TILE_RAYS):
            ra, rl, most, tint = ahead[ray], left[ray], per_m[ray], paint[ray]
            most, tint = _larger(met_per_m(a, ra, rl), a.paint, most, tint)
            most, tint = _larger(met_per_m(b, ra, rl), b.paint, most, tint)
            most, tint = _larger(met_per_m(c, ra, rl), c.paint, most, tint)
            most, tint = _larger(met_per_m(d, ra, rl), d.paint, most, tint)
            per_m[ray], paint[ray] = most, tint
    for ray in range(per_m.size):
        before_m, met_m = distance_m[ray], _ONE / per_m[ray]
        distance_m[ray] = met_m if met_m < before_m else before_m


@compiled_inline
def _larger(
    per_m: np.float32, paint: np.float32, most: np.float32, tint: np.float32
) -> tuple[np.float32, np.float32]:
    return (per_m if per_m > most else most), (paint if per_m > most else tint)


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
