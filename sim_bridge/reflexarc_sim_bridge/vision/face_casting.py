"""Rays that meet faces: turned boxes and the sides of polygons, of all layers together.

The faces that an eye can see are listed layer by layer (`list_turned`, `list_sides`); then every
ray meets them (`see_faces`), four faces at a time and 16 rays at once.
"""

import numpy as np

from reflexarc_sim_bridge.arrays.layout import BOX_PAINT, FACES, TILE_RAYS, EyeParams, Floats32
from reflexarc_sim_bridge.arrays.workspace import Faces, Judged, Picked, Workspace
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline, compiled_part
from reflexarc_sim_bridge.native.intrinsics import LANES
from reflexarc_sim_bridge.obstacles.near_lists import note_loss
from reflexarc_sim_bridge.vision.faces import (
    face,
    faces_of_boxes,
    faces_of_sides,
    fill_up,
    judge_faces,
    met_per_m,
)
from reflexarc_sim_bridge.vision.visible import (
    FOUR,
    View,
    copied,
    judge_sides,
    judge_turned,
    listed,
)

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)


@compiled_part
def list_turned(work: Workspace, i: int, near: Floats32, count: int, view: View, first: int) -> int:
    """List the turned boxes that agent i's eye can see as faces from `first` on; where they end."""
    judged, seen = work.sieve.judged, work.seen
    judge_turned(near, count, view, judged)
    n = _fitting(work, i, copied(near, view, judged, count, seen), first)
    if faces_of_boxes(seen, n, work.faces, first, judged):
        work.distance_m[:] = _ZERO
        work.paint[:] = seen[BOX_PAINT, _first_of(judged)]
    return first + n


@compiled_part
def list_sides(work: Workspace, i: int, near: Floats32, count: int, view: View, first: int) -> int:
    """List the sides of polygons that agent i's eye can see as faces from `first` on."""
    judge_sides(near, count, view, work.sieve.judged)
    n = _fitting(work, i, copied(near, view, work.sieve.judged, count, work.seen), first)
    faces_of_sides(work.seen, n, work.faces, first)
    return first + n


@compiled_part
def see_faces(eye: EyeParams, work: Workspace, count: int) -> None:
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


@compiled_inline
def _fitting(work: Workspace, i: int, count: int, first: int) -> int:
    """How many of these faces fit in from `first` on; the others are counted as lost."""
    room = work.faces.paint.size - LANES - first
    if count > room:
        note_loss(work.losses, i, FACES, count - room)
        return room
    return count


@compiled_inline
def _first_of(marked: Judged) -> int:
    k = 0
    while not marked[k]:
        k += 1
    return k


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
