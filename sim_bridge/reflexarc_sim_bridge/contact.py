"""What a moving body runs into, found along the swept step with the geometry that the rays see.

A body of radius r meets an obstacle where its middle meets the obstacle grown by r: a box with
round corners, a larger disc, and about the side of a polygon a stadium.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.compiled import compiled_inline, compiled_inner, compiled_part
from reflexarc_sim_bridge.geometry import meets_box_m, meets_disc_m, meets_side_m, reciprocal
from reflexarc_sim_bridge.near import displacement_m, place_in_layer_m
from reflexarc_sim_bridge.params import (
    AT_REST,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_X,
    BOX_Y,
    BOXES,
    DISC_RADIUS,
    DISC_X,
    DISC_Y,
    DISCS,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_X,
    SIDE_Y,
    SIDES,
    Floats32,
    Params,
)

TOUCHING_M = 1e-6
"""This close counts as touching: near places are float32 within some metres."""

_STEEPEST = 1e-12


@compiled_part
def free_share(params: Params, i: int, ahead_m: float, left_m: float) -> float:
    """Share of a straight step up to the first obstacle that an agent meets, infinity if none.

    Obstacles that move do so meanwhile: what counts is the agent's way in their frame.

    Args:
        params: the simulation.
        i: which agent.
        ahead_m: how far it goes along x.
        left_m: how far it goes along y.
    """
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane, share = world.planes[state.world], math.inf
    for number in range(plane.layers):
        layer, way_x_m, way_y_m = world.layers[state.world, number], ahead_m, left_m
        if layer.motion != AT_REST:
            from_x, from_y = displacement_m(layer, state.steps * plane.dt_s)
            to_x, to_y = displacement_m(layer, (state.steps + 1) * plane.dt_s)
            way_x_m -= to_x - from_x
            way_y_m -= to_y - from_y
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        boxes, discs = agents.boxes[i, number], agents.discs[i, number]
        sides, counts = agents.sides[i, number], agents.near_counts[i, number]
        near = _touched(boxes, discs, sides, counts, x_m, y_m, way_x_m, way_y_m, plane.radius_m)
        if near:
            share = min(
                share,
                _share(boxes, discs, sides, counts, x_m, y_m, way_x_m, way_y_m, plane.radius_m),
            )
    return share


@compiled_inner
def touches(params: Params, i: int) -> bool:
    """Whether an agent covers or touches an obstacle where it is."""
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane = world.planes[state.world]
    radius_m = plane.radius_m + TOUCHING_M
    for number in range(plane.layers):
        layer = world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        counts = agents.near_counts[i, number]
        if (
            _in_box(agents.boxes[i, number], counts[BOXES], x_m, y_m, radius_m)
            or _in_disc(agents.discs[i, number], counts[DISCS], x_m, y_m, radius_m)
            or _in_polygon(agents.sides[i, number], counts[SIDES], x_m, y_m, radius_m)
        ):
            return True
    return False


@compiled_inline
def _touched(
    boxes: Floats32,
    discs: Floats32,
    sides: Floats32,
    counts: npt.NDArray[np.int64],
    x_m: float,
    y_m: float,
    way_x_m: float,
    way_y_m: float,
    radius_m: float,
) -> bool:
    """Whether obstacles meet the step's bounding box: nearly always none, and cheap to say."""
    x, y = np.float32(x_m + 0.5 * way_x_m), np.float32(y_m + 0.5 * way_y_m)
    reach_x = np.float32(0.5 * abs(way_x_m) + radius_m + TOUCHING_M)
    reach_y = np.float32(0.5 * abs(way_y_m) + radius_m + TOUCHING_M)
    touched = _boxes_touched(boxes, counts[BOXES], x, y, reach_x, reach_y)
    if counts[DISCS]:
        touched |= _discs_touched(discs, counts[DISCS], x, y, reach_x, reach_y)
    if counts[SIDES]:
        touched |= _sides_touched(sides, counts[SIDES], x, y, reach_x, reach_y)
    return touched


@compiled_inner
def _share(
    boxes: Floats32,
    discs: Floats32,
    sides: Floats32,
    counts: npt.NDArray[np.int64],
    x_m: float,
    y_m: float,
    way_x_m: float,
    way_y_m: float,
    radius_m: float,
) -> float:
    length_m = math.hypot(way_x_m, way_y_m)
    ahead, left = (way_x_m / length_m, way_y_m / length_m) if length_m > 0.0 else (1.0, 0.0)
    met_m = min(
        _first_box_m(boxes, counts[BOXES], x_m, y_m, ahead, left, length_m, radius_m),
        _first_disc_m(discs, counts[DISCS], x_m, y_m, ahead, left, length_m, radius_m),
        _first_side_m(sides, counts[SIDES], x_m, y_m, ahead, left, length_m, radius_m),
    )
    if met_m > length_m:
        return math.inf
    return met_m / length_m if length_m > 0.0 else 0.0


@compiled_inline
def _boxes_touched(
    near: Floats32, count: int, x: np.float32, y: np.float32, rx: np.float32, ry: np.float32
) -> bool:
    touched = False
    for k in range(count):
        along = abs(near[BOX_X, k] - x) <= near[BOX_HALF_LENGTH, k] + rx
        across = abs(near[BOX_Y, k] - y) <= near[BOX_HALF_WIDTH, k] + ry
        touched |= along & across
    return touched


@compiled_inline
def _discs_touched(
    near: Floats32, count: int, x: np.float32, y: np.float32, rx: np.float32, ry: np.float32
) -> bool:
    touched = False
    for k in range(count):
        radius = near[DISC_RADIUS, k]
        along = abs(near[DISC_X, k] - x) <= radius + rx
        touched |= along & (abs(near[DISC_Y, k] - y) <= radius + ry)
    return touched


@compiled_inline
def _sides_touched(
    near: Floats32, count: int, x: np.float32, y: np.float32, rx: np.float32, ry: np.float32
) -> bool:
    touched, half = False, np.float32(0.5)
    for k in range(count):
        ahead, left = half * near[SIDE_AHEAD, k], half * near[SIDE_LEFT, k]
        along = abs(near[SIDE_X, k] + ahead - x) <= abs(ahead) + rx
        touched |= along & (abs(near[SIDE_Y, k] + left - y) <= abs(left) + ry)
    return touched


@compiled_inline
def _first_box_m(
    near: Floats32,
    count: int,
    x_m: float,
    y_m: float,
    ahead: float,
    left: float,
    length_m: float,
    radius_m: float,
) -> float:
    per_ahead, per_left = reciprocal(ahead, _STEEPEST), reciprocal(left, _STEEPEST)
    first_m = math.inf
    for k in range(count):
        x, y = np.float64(near[BOX_X, k]) - x_m, np.float64(near[BOX_Y, k]) - y_m
        length, width = np.float64(near[BOX_HALF_LENGTH, k]), np.float64(near[BOX_HALF_WIDTH, k])
        if max(abs(x) - length, abs(y) - width) > length_m + radius_m:
            continue
        if radius_m == 0.0:
            first_m = min(first_m, meets_box_m(x, y, length, width, per_ahead, per_left))
            continue
        longer = meets_box_m(x, y, length + radius_m, width, per_ahead, per_left)
        wider = meets_box_m(x, y, length, width + radius_m, per_ahead, per_left)
        first_m = min(first_m, longer, wider)
        for corner in range(4):
            corner_x = x + (length if corner & 1 else -length)
            corner_y = y + (width if corner & 2 else -width)
            first_m = min(first_m, meets_disc_m(corner_x, corner_y, radius_m, ahead, left))
    return first_m


@compiled_inline
def _first_disc_m(
    near: Floats32,
    count: int,
    x_m: float,
    y_m: float,
    ahead: float,
    left: float,
    length_m: float,
    radius_m: float,
) -> float:
    first_m = math.inf
    for k in range(count):
        x, y = np.float64(near[DISC_X, k]) - x_m, np.float64(near[DISC_Y, k]) - y_m
        radius = np.float64(near[DISC_RADIUS, k]) + radius_m
        if max(abs(x), abs(y)) > length_m + radius:
            continue
        first_m = min(first_m, meets_disc_m(x, y, radius, ahead, left))
    return first_m


@compiled_inline
def _first_side_m(
    near: Floats32,
    count: int,
    x_m: float,
    y_m: float,
    ahead: float,
    left: float,
    length_m: float,
    radius_m: float,
) -> float:
    first_m = math.inf
    for k in range(count):
        x, y = np.float64(near[SIDE_X, k]) - x_m, np.float64(near[SIDE_Y, k]) - y_m
        side_x, side_y = np.float64(near[SIDE_AHEAD, k]), np.float64(near[SIDE_LEFT, k])
        if max(abs(x), abs(y)) > abs(side_x) + abs(side_y) + length_m + radius_m:
            continue
        if radius_m > 0.0:
            first_m = min(first_m, meets_disc_m(x, y, radius_m, ahead, left))
            per_length = radius_m / max(math.hypot(side_x, side_y), _STEEPEST)
            x, y = x + side_y * per_length, y - side_x * per_length
        first_m = min(first_m, meets_side_m(x, y, side_x, side_y, ahead, left))
    return first_m


@compiled_inline
def _in_box(near: Floats32, count: int, x_m: float, y_m: float, radius_m: float) -> bool:
    found = 0
    for k in range(count):
        away_x = abs(near[BOX_X, k] - x_m) - near[BOX_HALF_LENGTH, k]
        away_y = abs(near[BOX_Y, k] - y_m) - near[BOX_HALF_WIDTH, k]
        away_x, away_y = max(away_x, 0.0), max(away_y, 0.0)
        found += away_x * away_x + away_y * away_y <= radius_m * radius_m
    return found > 0


@compiled_inline
def _in_disc(near: Floats32, count: int, x_m: float, y_m: float, radius_m: float) -> bool:
    found = 0
    for k in range(count):
        dx, dy, reach = (
            near[DISC_X, k] - x_m,
            near[DISC_Y, k] - y_m,
            near[DISC_RADIUS, k] + radius_m,
        )
        found += dx * dx + dy * dy <= reach * reach
    return found > 0


@compiled_inline
def _in_polygon(near: Floats32, count: int, x_m: float, y_m: float, radius_m: float) -> bool:
    """Whether a side is near, or a polygon holds the place.

    All polygons go round counter-clockwise, so that the sides which pass beside a place, upwards
    ones less downwards ones, say how many of them hold it (winding number).
    """
    winding, close = 0, 0
    for k in range(count):
        x, y = near[SIDE_X, k] - x_m, near[SIDE_Y, k] - y_m
        end_x, end_y = x + near[SIDE_AHEAD, k], y + near[SIDE_LEFT, k]
        if (y <= 0.0) != (end_y <= 0.0):
            beside = x * end_y - end_x * y
            winding += (beside > 0.0) & (end_y > 0.0)
            winding -= (beside < 0.0) & (end_y <= 0.0)
        close += _squared_distance_m2(x, y, end_x - x, end_y - y) <= radius_m * radius_m
    return winding > 0 or close > 0


@compiled_inline
def _squared_distance_m2(x: float, y: float, side_x: float, side_y: float) -> float:
    """From the origin to a side that begins at (x, y)."""
    along = -(x * side_x + y * side_y) / max(side_x * side_x + side_y * side_y, _STEEPEST)
    along = min(max(along, 0.0), 1.0)
    dx, dy = x + along * side_x, y + along * side_y
    return dx * dx + dy * dy
