"""Which near obstacles an eye can see: those within range that reach into its wedge.

The wedge lies between the directions of the rightmost and the leftmost ray. First every obstacle
is judged, sixteen at once; then those that pass are listed in fours, or copied. An eye of several
tiles of rays picks once for all of them, copies what it picked, and picks from that for each tile.
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
    PLACE_X,
    PLACE_Y,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_X,
    SIDE_Y,
    Floats32,
)
from reflexarc_sim_bridge.arrays.workspace import Judged, Picked
from reflexarc_sim_bridge.native.decorators import compiled_disjoint
from reflexarc_sim_bridge.native.intrinsics import LANES, keep, whole
from reflexarc_sim_bridge.obstacles.geometry import turned_back

FOUR = 4
"""Obstacles that a ray is tested against at a time."""

_ZERO, _HALF = np.float32(0.0), np.float32(0.5)
_SLIGHT_M = np.float32(1e-5)
"""A ray along a wedge's edge, to where two sides meet, must not be beside both by rounding."""


class View(NamedTuple):
    """Where an eye or a tile of its rays is, and which way it looks."""

    x: np.float32
    y: np.float32
    range_m: np.float32
    right_x: np.float32
    """Direction of the rightmost ray. Where both parts are 0, any direction will do."""
    right_y: np.float32
    left_x: np.float32
    """Direction of the leftmost ray."""
    left_y: np.float32


@compiled_disjoint
def judge_boxes(
    near: Floats32,
    count: int,
    view: View,
    judged: Judged,
) -> None:
    """Mark the boxes that a view can see.

    Args:
        near: rows BOX_*: (5, capacity).
        count: columns of it in use.
        view: from where, in the frame of `near`.
        judged: filled: (capacity,).
    """
    x, y, range_m, right_x, right_y, left_x, left_y = view
    for k in range(whole(count)):
        dx, dy = near[BOX_X, k] - x, near[BOX_Y, k] - y
        half_length, half_width = near[BOX_HALF_LENGTH, k], near[BOX_HALF_WIDTH, k]
        away_x, away_y = abs(dx) - half_length, abs(dy) - half_width
        away_x = away_x if away_x > _ZERO else _ZERO
        away_y = away_y if away_y > _ZERO else _ZERO
        from_right = right_x * dy - right_y * dx
        from_right += half_length * abs(right_y) + half_width * abs(right_x)
        from_left = dx * left_y - dy * left_x
        from_left += half_length * abs(left_y) + half_width * abs(left_x)
        judged[k] = (
            (k < count)
            & (away_x * away_x + away_y * away_y < range_m * range_m)
            & (from_right >= _ZERO)
            & (from_left >= _ZERO)
        )


@compiled_disjoint
def judge_turned(
    near: Floats32,
    count: int,
    view: View,
    judged: Judged,
) -> None:
    """Mark the turned boxes that a view can see, all rows BOX_*, each in its own frame."""
    x, y, range_m, right_x, right_y, left_x, left_y = view
    for k in range(whole(count)):
        cos, sin = near[BOX_COS, k], near[BOX_SIN, k]
        dx, dy = turned_back(near[BOX_X, k] - x, near[BOX_Y, k] - y, cos, sin)
        rightmost_x, rightmost_y = turned_back(right_x, right_y, cos, sin)
        leftmost_x, leftmost_y = turned_back(left_x, left_y, cos, sin)
        half_length, half_width = near[BOX_HALF_LENGTH, k], near[BOX_HALF_WIDTH, k]
        away_x, away_y = abs(dx) - half_length, abs(dy) - half_width
        away_x = away_x if away_x > _ZERO else _ZERO
        away_y = away_y if away_y > _ZERO else _ZERO
        from_right = rightmost_x * dy - rightmost_y * dx
        from_right += half_length * abs(rightmost_y) + half_width * abs(rightmost_x)
        from_left = dx * leftmost_y - dy * leftmost_x
        from_left += half_length * abs(leftmost_y) + half_width * abs(leftmost_x)
        judged[k] = (
            (k < count)
            & (away_x * away_x + away_y * away_y < range_m * range_m)
            & (from_right >= -_SLIGHT_M)
            & (from_left >= -_SLIGHT_M)
        )


@compiled_disjoint
def judge_discs(
    near: Floats32,
    count: int,
    view: View,
    judged: Judged,
) -> None:
    """Mark the discs that a view can see, rows DISC_*."""
    x, y, range_m, right_x, right_y, left_x, left_y = view
    for k in range(whole(count)):
        dx, dy, radius = near[DISC_X, k] - x, near[DISC_Y, k] - y, near[DISC_RADIUS, k]
        farthest = range_m + radius
        from_right = right_x * dy - right_y * dx + radius
        from_left = dx * left_y - dy * left_x + radius
        judged[k] = (
            (k < count)
            & (dx * dx + dy * dy < farthest * farthest)
            & (from_right >= _ZERO)
            & (from_left >= _ZERO)
        )


@compiled_disjoint
def judge_sides(
    near: Floats32,
    count: int,
    view: View,
    judged: Judged,
) -> None:
    """Mark the sides that face the eye and that a view can see, rows SIDE_*.

    Of the two ends the one that lies farther into the wedge counts.
    """
    x, y, range_m, right_x, right_y, left_x, left_y = view
    for k in range(whole(count)):
        dx, dy = near[SIDE_X, k] - x, near[SIDE_Y, k] - y
        ahead, left = near[SIDE_AHEAD, k], near[SIDE_LEFT, k]
        away_x = abs(dx + _HALF * ahead) - _HALF * abs(ahead)
        away_y = abs(dy + _HALF * left) - _HALF * abs(left)
        away_x = away_x if away_x > _ZERO else _ZERO
        away_y = away_y if away_y > _ZERO else _ZERO
        begins, grows = right_x * dy - right_y * dx, right_x * left - right_y * ahead
        from_right = begins if grows < _ZERO else begins + grows
        begins, grows = dx * left_y - dy * left_x, ahead * left_y - left * left_x
        from_left = begins if grows < _ZERO else begins + grows
        judged[k] = (
            (k < count)
            & (away_x * away_x + away_y * away_y < range_m * range_m)
            & (ahead * dy - left * dx > _ZERO)
            & (from_right >= -_SLIGHT_M)
            & (from_left >= -_SLIGHT_M)
        )


@compiled_disjoint
def copied(near: Floats32, view: View, judged: Judged, count: int, seen: Floats32) -> int:
    """Copy the obstacles that are marked, relative to the eye.

    Args:
        near: the near list.
        view: from where, in the frame of `near`.
        judged: whether they passed: (capacity,).
        count: columns of `near` in use.
        seen: filled, rows as of `near`.

    Returns:
        How many.
    """
    n = 0
    for row in range(near.shape[0]):
        n = 0
        for first in range(0, count, LANES):
            n = keep(near[row], judged, first, seen[row], n)
    for k in range(n):
        seen[PLACE_X, k], seen[PLACE_Y, k] = seen[PLACE_X, k] - view.x, seen[PLACE_Y, k] - view.y
    return n


@compiled_disjoint
def listed(numbers: Picked, judged: Judged, count: int, picked: Picked) -> int:
    """List the numbers of the obstacles that are marked.

    Args:
        numbers: 0, 1, 2, …: (capacity,).
        judged: whether they passed: (capacity,).
        count: how many obstacles were judged.
        picked: filled: (capacity + LANES,).

    Returns:
        How many; the last four are filled up with one of them.
    """
    n = 0
    for first in range(0, count, LANES):
        n = keep(numbers, judged, first, picked, n)
    for k in range(n, n + FOUR):
        picked[np.uintp(k)] = picked[0]
    return n
