"""Which near obstacles a tile of rays can meet: those within range that reach into its wedge.

The wedge lies between the directions of the tile's rightmost and leftmost ray. First every obstacle
is judged, many at once; then those that pass are listed, written first and counted after, as no
branch foresees them.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.compiled import compiled_inline
from reflexarc_sim_bridge.params import (
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
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

Picked = npt.NDArray[np.int64]
Judged = npt.NDArray[np.bool_]

_ZERO, _HALF = np.float32(0.0), np.float32(0.5)
_SLIGHT_M = np.float32(1e-5)
"""A ray along a wedge's edge, to where two sides meet, must not be beside both by rounding."""


@compiled_inline
def judge_boxes(
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    range_m: np.float32,
    right_x: np.float32,
    right_y: np.float32,
    left_x: np.float32,
    left_y: np.float32,
    judged: Judged,
) -> None:
    """Boxes.

    Args:
        near: rows BOX_*: (5, capacity).
        count: columns of it in use.
        x: the eye, in the frame of `near`.
        y: the same.
        range_m: of the eye.
        right_x: direction of the rightmost ray. Where both are 0, any direction will do.
        right_y: the same.
        left_x: direction of the leftmost ray.
        left_y: the same.
        judged: filled: (capacity,).
    """
    for k in range(count):
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
            (away_x * away_x + away_y * away_y < range_m * range_m)
            & (from_right >= _ZERO)
            & (from_left >= _ZERO)
        )


@compiled_inline
def judge_discs(
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    range_m: np.float32,
    right_x: np.float32,
    right_y: np.float32,
    left_x: np.float32,
    left_y: np.float32,
    judged: Judged,
) -> None:
    """Discs, rows DISC_*; arguments as for boxes."""
    for k in range(count):
        dx, dy, radius = near[DISC_X, k] - x, near[DISC_Y, k] - y, near[DISC_RADIUS, k]
        farthest = range_m + radius
        from_right = right_x * dy - right_y * dx + radius
        from_left = dx * left_y - dy * left_x + radius
        judged[k] = (
            (dx * dx + dy * dy < farthest * farthest) & (from_right >= _ZERO) & (from_left >= _ZERO)
        )


@compiled_inline
def judge_sides(
    near: Floats32,
    count: int,
    x: np.float32,
    y: np.float32,
    range_m: np.float32,
    right_x: np.float32,
    right_y: np.float32,
    left_x: np.float32,
    left_y: np.float32,
    judged: Judged,
) -> None:
    """Sides that face the eye, rows SIDE_*; the end that lies farther into the wedge counts."""
    for k in range(count):
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
            (away_x * away_x + away_y * away_y < range_m * range_m)
            & (ahead * dy - left * dx > _ZERO)
            & (from_right >= -_SLIGHT_M)
            & (from_left >= -_SLIGHT_M)
        )


@compiled_inline
def listed(judged: Judged, count: int, nothing: int, picked: Picked) -> int:
    """List those that passed in fours, filled up with column `nothing`; returns how many."""
    n = 0
    for k in range(count):
        picked[np.uintp(n)] = k
        n += judged[k]
    filled = (n + 3) & ~3
    for k in range(n, filled):
        picked[k] = nothing
    return filled
