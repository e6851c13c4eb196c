"""Striped surfaces: where on one a point lies, and the shade of the stripe there.

A stripe is a function of the seed, the surface and floor(place / length of a stripe), and of
nothing else: it keeps its shade whenever, from wherever and by whomever it is looked at. Places
are lengths along a surface:

    wall of a corridor   x, less what its stripes have moved ahead
    rectangle            along its outline, counter-clockwise, from its front left corner
    disc                 radius · angle, counter-clockwise, from ahead

What a ray meets is known only after it has met all; so the near lists of a striped layer hold marks
in place of colours, which say where to find the obstacle, and its surface in one more row. Other
layers have colours there, and all of this is skipped.
"""

import math

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_PAINT,
    BOXES,
    DISC_PAINT,
    DISCS,
    MARK_LAYERS,
    MARK_LISTS,
    SIDE_PAINT,
    SIDES,
    TURNED,
    Floats32,
    Near,
    Row,
)
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import joined
from reflexarc_sim_bridge.obstacles.keys import BLOCK
from reflexarc_sim_bridge.obstacles.obstacle import colour_of

_STRIPES = np.uint64(0x7374726970657321)
"""Keeps keys of stripes apart from those of chunks, whose numbers are small: "stripes!"."""


@compiled_inline
def marked(number: int, kind: int, entry: int) -> np.float32:
    """The mark of an obstacle, below the −1 of nothing: −2, −3, … up to what float32 holds exactly.

    Args:
        number: its layer.
        kind: its list: BOXES to SIDES.
        entry: its column there; of a side of a corridor, which wall.
    """
    return np.float32(-2 - ((entry * MARK_LISTS + kind) * MARK_LAYERS + number))


@compiled_inline
def read_mark(mark: np.float32) -> tuple[int, int, int]:
    """Layer, list and entry of a mark; the layer is −1 if it is a colour, or nothing."""
    bits: int = np.int64(-2) - np.int64(mark)  # type: ignore[assignment]  # int, compiled
    if bits < 0:
        return -1, 0, 0
    return bits % MARK_LAYERS, bits // MARK_LAYERS % MARK_LISTS, bits // (MARK_LAYERS * MARK_LISTS)


@compiled_inner
def mark_surfaces(near: Near, number: int) -> None:
    """Put marks in place of the surfaces that the lists of a striped layer were filled with."""
    _mark_entries(near.boxes, BOX_PAINT, near.counts[BOXES], number, BOXES)
    _mark_entries(near.turned, BOX_PAINT, near.counts[TURNED], number, TURNED)
    _mark_entries(near.discs, DISC_PAINT, near.counts[DISCS], number, DISCS)
    for k in range(near.counts[SIDES]):
        near.sides[SIDE_PAINT, k] = marked(number, SIDES, int(near.sides[SIDE_PAINT, k]))


@compiled_inline
def _mark_entries(rows: Floats32, paint: int, count: int, number: int, kind: int) -> None:
    last = rows.shape[0] - 1
    for k in range(count):
        rows[last, k] = rows[paint, k]
        rows[paint, k] = marked(number, kind, k)


@compiled_inner
def stripe_at(
    layer: Row, layer_key: np.uint64, surface: int, place_m: float, contrast: float
) -> int:
    """Which stripe a place of a surface is in, and its colour: 8 bits each of red, green, blue.

    Args:
        layer: whose surface; its row.
        layer_key: its key.
        surface: which of its surfaces.
        place_m: where on it.
        contrast: of the surface: of a wall its own, of all else 1.
    """
    stripe = math.floor(place_m / layer.stripes_m)
    key = joined(joined(layer_key, _STRIPES), np.uint64(surface))
    return colour_of(layer, key, np.uint64(stripe) * BLOCK, contrast)


@compiled_inline
def contrast_of_wall(layer: Row, wall: int) -> float:
    """Of the right (0) or left (1) wall of a corridor."""
    contrast: float = layer.left_contrast if wall == 1 else layer.right_contrast
    return contrast


@compiled_inline
def place_on_wall_m(layer: Row, wall: int, x_m: float, time_s: float) -> float:
    """Place on the right (0) or left (1) wall of a corridor, at x in the world's frame."""
    speed_mps: float = layer.left_wall_mps if wall == 1 else layer.right_wall_mps
    return x_m - speed_mps * time_s


@compiled_inline
def place_on_box_m(x_m: float, y_m: float, half_length_m: float, half_width_m: float) -> float:
    """Place on a rectangle, of the point nearest to one in the frame of its middle and its sides.

    The side is the one that the point is farthest out from: of two at a corner either will do, as
    the place there is the same.
    """
    x_m = min(max(x_m, -half_length_m), half_length_m)
    y_m = min(max(y_m, -half_width_m), half_width_m)
    length_m, width_m = 2.0 * half_length_m, 2.0 * half_width_m
    if abs(y_m) - half_width_m >= abs(x_m) - half_length_m:
        left_m, right_m = half_length_m - x_m, length_m + width_m + half_length_m + x_m
        return left_m if y_m >= 0.0 else right_m
    back_m, front_m = length_m + half_width_m - y_m, 2.0 * length_m + width_m + half_width_m + y_m
    return back_m if x_m < 0.0 else front_m


@compiled_inline
def place_on_disc_m(x_m: float, y_m: float, radius_m: float) -> float:
    """Place on a disc, in the direction of a point in the frame of its middle."""
    angle_rad = math.atan2(y_m, x_m)
    return radius_m * (angle_rad if angle_rad >= 0.0 else angle_rad + 2.0 * math.pi)
