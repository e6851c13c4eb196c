"""Broad phase of the contact test: which obstacles touch the upright box around a body's step.

Nearly always none does, and that is cheap to find out; the others are tested by `contact.py`.
"""

from typing import NamedTuple

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_SIN,
    BOX_X,
    BOX_Y,
    DISC_RADIUS,
    DISC_X,
    DISC_Y,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_X,
    SIDE_Y,
    Floats32,
)
from reflexarc_sim_bridge.arrays.workspace import Judged
from reflexarc_sim_bridge.motion.overlap import TOUCHING_M
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline
from reflexarc_sim_bridge.native.intrinsics import whole


class Way(NamedTuple):
    """A straight step of a body, in a layer's frame."""

    x_m: float
    """Where it begins."""
    y_m: float
    ahead_m: float
    """How far it goes along x."""
    left_m: float
    """How far it goes along y."""
    radius_m: float
    """Of the body."""


class WayBounds(NamedTuple):
    """An upright box, by its middle and half its sides."""

    x: np.float32
    y: np.float32
    reach_x: np.float32
    reach_y: np.float32


@compiled_inline
def around(way: Way) -> WayBounds:
    """The box that holds a body on its way."""
    x, y = np.float32(way.x_m + 0.5 * way.ahead_m), np.float32(way.y_m + 0.5 * way.left_m)
    reach_x = np.float32(0.5 * abs(way.ahead_m) + way.radius_m + TOUCHING_M)
    reach_y = np.float32(0.5 * abs(way.left_m) + way.radius_m + TOUCHING_M)
    return WayBounds(x, y, reach_x, reach_y)


@compiled_disjoint
def boxes_touched(near: Floats32, count: int, box: WayBounds, judged: Judged) -> bool:
    """Note in `judged` which boxes touch the box around a way; whether any does."""
    touched = False
    for k in range(whole(count)):
        along = abs(near[BOX_X, k] - box.x) <= near[BOX_HALF_LENGTH, k] + box.reach_x
        across = abs(near[BOX_Y, k] - box.y) <= near[BOX_HALF_WIDTH, k] + box.reach_y
        judged[k] = (k < count) & along & across
        touched |= (k < count) & along & across
    return touched


@compiled_disjoint
def turned_touched(near: Floats32, count: int, box: WayBounds, judged: Judged) -> bool:
    """Note in `judged` which turned boxes may touch the box around a way; whether any may.

    The upright box around each of them is tested.
    """
    touched = False
    for k in range(whole(count)):
        cos, sin = abs(near[BOX_COS, k]), abs(near[BOX_SIN, k])
        half_length, half_width = near[BOX_HALF_LENGTH, k], near[BOX_HALF_WIDTH, k]
        along = abs(near[BOX_X, k] - box.x) <= half_length * cos + half_width * sin + box.reach_x
        across = abs(near[BOX_Y, k] - box.y) <= half_length * sin + half_width * cos + box.reach_y
        judged[k] = (k < count) & along & across
        touched |= (k < count) & along & across
    return touched


@compiled_disjoint
def discs_touched(near: Floats32, count: int, box: WayBounds, judged: Judged) -> bool:
    """Note in `judged` which discs touch the box around a way; whether any does."""
    touched = False
    for k in range(whole(count)):
        radius = near[DISC_RADIUS, k]
        along = abs(near[DISC_X, k] - box.x) <= radius + box.reach_x
        across = abs(near[DISC_Y, k] - box.y) <= radius + box.reach_y
        judged[k] = (k < count) & along & across
        touched |= (k < count) & along & across
    return touched


@compiled_disjoint
def sides_touched(near: Floats32, count: int, box: WayBounds, judged: Judged) -> bool:
    """Note in `judged` which sides of polygons may touch the box around a way; whether any may.

    The upright box around each of them is tested.
    """
    touched, half = False, np.float32(0.5)
    for k in range(whole(count)):
        ahead, left = half * near[SIDE_AHEAD, k], half * near[SIDE_LEFT, k]
        along = abs(near[SIDE_X, k] + ahead - box.x) <= abs(ahead) + box.reach_x
        across = abs(near[SIDE_Y, k] + left - box.y) <= abs(left) + box.reach_y
        judged[k] = (k < count) & along & across
        touched |= (k < count) & along & across
    return touched
