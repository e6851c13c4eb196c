"""Straight faces of obstacles as coefficients that a ray's direction is multiplied with.

A ray goes from the eye along a unit vector d. A face with normal n at distance c is met after
s = c / (n·d): 1 / s is linear in d, as depth is in a picture. The ray passes between two ends r and
l, the right one and the left one, where r × d ≥ 0 and d × l ≥ 0: linear, too. Of the two faces that
a box shows the later one counts (Kay and Kajiya's slabs); a side of a polygon has one.

So a ray takes a few multiplications an obstacle and no division; all else is worked out once for
all rays, sixteen obstacles at a time.
"""

import math
from typing import NamedTuple

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_PAINT,
    BOX_SIN,
    BOX_X,
    BOX_Y,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_PAINT,
    SIDE_X,
    SIDE_Y,
    TILE_RAYS,
    Floats32,
)
from reflexarc_sim_bridge.arrays.workspace import Faces, Judged
from reflexarc_sim_bridge.native.decorators import (
    compiled_disjoint,
    compiled_inline,
)
from reflexarc_sim_bridge.native.intrinsics import multiply_add, whole
from reflexarc_sim_bridge.obstacles.geometry import turned_back
from reflexarc_sim_bridge.vision.visible import FOUR

_ZERO, _ONE = np.float32(0.0), np.float32(1.0)
_LITTLE, _MORE = np.float32(1e-6), np.float32(1.0 + 1e-6)
"""The ends of a side get a little more, so that no ray slips through where two sides meet."""
_SLIGHT_M = np.float32(1e-5)


class Face(NamedTuple):
    """The coefficients of one face: a row of `Faces`."""

    one_x: np.float32
    one_y: np.float32
    other_x: np.float32
    other_y: np.float32
    right_x: np.float32
    right_y: np.float32
    left_x: np.float32
    left_y: np.float32
    paint: np.float32


@compiled_inline
def face(faces: Faces, k: np.uint32) -> Face:
    """Face k."""
    return Face(
        faces.one_x[k],
        faces.one_y[k],
        faces.other_x[k],
        faces.other_y[k],
        faces.right_x[k],
        faces.right_y[k],
        faces.left_x[k],
        faces.left_y[k],
        faces.paint[k],
    )


@compiled_inline
def met_per_m(met: Face, ahead: np.float32, left: np.float32) -> np.float32:
    """1 / length of a ray up to a face, 0 if it passes."""
    one = multiply_add(met.one_x, ahead, met.one_y * left)
    other = multiply_add(met.other_x, ahead, met.other_y * left)
    to_right = multiply_add(met.right_x, ahead, met.right_y * left)
    to_left = multiply_add(met.left_x, ahead, met.left_y * left)
    least = to_right if to_right < to_left else to_left
    per_m = one if one < other else other
    return per_m if least >= _ZERO else _ZERO


@compiled_disjoint
def faces_of_boxes(boxes: Floats32, count: int, faces: Faces, first: int, inside: Judged) -> bool:
    """The faces of turned boxes that an eye at the origin sees.

    Args:
        boxes: rows BOX_*: (7, capacity).
        count: columns of it in use.
        faces: filled from `first` on, up to LANES too many.
        first: where.
        inside: filled: within which of them the eye is: (capacity,).

    Returns:
        Whether it is in any.
    """
    any_inside = False
    for k in range(whole(count)):
        cos, sin = boxes[BOX_COS, k], boxes[BOX_SIN, k]
        along, across = turned_back(boxes[BOX_X, k], boxes[BOX_Y, k], cos, sin)
        half_length, half_width = boxes[BOX_HALF_LENGTH, k], boxes[BOX_HALF_WIDTH, k]
        seen = _face_of_box(along, across, half_length, half_width, cos, sin, boxes[BOX_PAINT, k])
        _put(faces, first + k, seen)
        is_inside = (k < count) & (abs(along) <= half_length) & (abs(across) <= half_width)
        inside[k] = is_inside
        any_inside |= is_inside
    return any_inside


@compiled_inline
def _face_of_box(
    along: np.float32,
    across: np.float32,
    half_length: np.float32,
    half_width: np.float32,
    cos: np.float32,
    sin: np.float32,
    paint: np.float32,
) -> Face:
    """The faces of a box whose middle lies at (along, across) in the frame turned with it.

    That frame is mirrored, so that the middle lies ahead and to the left.
    """
    mirror_x, mirror_y = math.copysign(_ONE, along), math.copysign(_ONE, across)
    ahead_x, ahead_y = mirror_x * cos, mirror_x * sin
    aside_x, aside_y = -mirror_y * sin, mirror_y * cos
    near_x, far_x = abs(along) - half_length, abs(along) + half_length
    near_y, far_y = abs(across) - half_width, abs(across) + half_width
    shows_x, shows_y = near_x > _ZERO, near_y > _ZERO
    one_x, one_y = ahead_x / near_x, ahead_y / near_x
    other_x, other_y = aside_x / near_y, aside_y / near_y
    right, left = far_x if shows_y else near_x, far_y if shows_x else near_y
    return Face(
        one_x if shows_x else other_x,
        one_y if shows_x else other_y,
        other_x if shows_y else one_x,
        other_y if shows_y else one_y,
        right * aside_x - near_y * ahead_x,
        right * aside_y - near_y * ahead_y,
        left * ahead_x - near_x * aside_x,
        left * ahead_y - near_x * aside_y,
        paint,
    )


@compiled_disjoint
def faces_of_sides(sides: Floats32, count: int, faces: Faces, first: int) -> None:
    """The faces of sides that face the eye, rows SIDE_*: (5, capacity)."""
    for k in range(whole(count)):
        x, y = sides[SIDE_X, k], sides[SIDE_Y, k]
        ahead, left = sides[SIDE_AHEAD, k], sides[SIDE_LEFT, k]
        _put(faces, first + k, _face_of_side(x, y, ahead, left, sides[SIDE_PAINT, k]))


@compiled_inline
def _face_of_side(
    x: np.float32, y: np.float32, ahead: np.float32, left: np.float32, paint: np.float32
) -> Face:
    """The face of a side from (x, y) along (ahead, left)."""
    clear = ahead * y - left * x
    per_x, per_y = -left / clear, ahead / clear
    right_x, right_y = y - _LITTLE * left, _LITTLE * ahead - x
    left_x, left_y = -_MORE * left - y, _MORE * ahead + x
    return Face(per_x, per_y, per_x, per_y, right_x, right_y, left_x, left_y, paint)


@compiled_inline
def _put(faces: Faces, k: int, seen: Face) -> None:
    at = np.uintp(k)
    faces.one_x[at], faces.one_y[at] = seen.one_x, seen.one_y
    faces.other_x[at], faces.other_y[at] = seen.other_x, seen.other_y
    faces.right_x[at], faces.right_y[at] = seen.right_x, seen.right_y
    faces.left_x[at], faces.left_y[at] = seen.left_x, seen.left_y
    faces.paint[at] = seen.paint


@compiled_inline
def fill_up(faces: Faces, count: int) -> None:
    """Pad the face list with zeros to a multiple of four; a zero face is never hit."""
    for k in range(count, count + FOUR):
        at = np.uintp(k)
        faces.one_x[at] = faces.one_y[at] = faces.other_x[at] = faces.other_y[at] = _ZERO


@compiled_disjoint
def judge_faces(faces: Faces, count: int, ahead: Floats32, left: Floats32, judged: Judged) -> None:
    """Which faces a tile of rays can meet.

    Along an arc of less than half a circle what is linear in the direction is positive somewhere
    only if it is so at one of its ends.

    Args:
        faces: what the eye can see.
        count: how many.
        ahead: directions of the rays: (TILE_RAYS,).
        left: the same.
        judged: filled: (capacity,).
    """
    right_x, right_y = ahead[TILE_RAYS - 1], left[TILE_RAYS - 1]
    left_x, left_y = ahead[0], left[0]
    for k in range(whole(count)):
        x, y = faces.right_x[k], faces.right_y[k]
        from_right = max(x * right_x + y * right_y, x * left_x + y * left_y)
        x, y = faces.left_x[k], faces.left_y[k]
        from_left = max(x * right_x + y * right_y, x * left_x + y * left_y)
        judged[k] = (k < count) & (from_right >= -_SLIGHT_M) & (from_left >= -_SLIGHT_M)
