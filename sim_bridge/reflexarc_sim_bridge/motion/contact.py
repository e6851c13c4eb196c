"""Contacts: the first obstacle that a body meets along its straight step (swept contact test).

A body of radius r meets an obstacle where its middle meets the obstacle grown by r: a box with
round corners, a larger disc, and about the side of a polygon a stadium.
"""

import math

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    AT_REST,
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_SIN,
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
    TURNED,
    Floats32,
    Near,
    Params,
)
from reflexarc_sim_bridge.arrays.workspace import Judged, Workspace
from reflexarc_sim_bridge.motion.broad_phase import (
    Way,
    around,
    boxes_touched,
    discs_touched,
    sides_touched,
    turned_touched,
)
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.obstacles.geometry import (
    meets_box_m,
    meets_disc_m,
    meets_side_m,
    reciprocal,
    turned_back,
)
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m, near_of, place_in_layer_m

_STEEPEST = 1e-12


@compiled_inner
def free_share(params: Params, work: Workspace, i: int, ahead_m: float, left_m: float) -> float:
    """Share of a straight step up to the first obstacle that is met; infinity if none is.

    Obstacles that move do so meanwhile: what counts is the agent's way in their frame.

    Args:
        params: the simulation.
        work: scratch.
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
        way = Way(x_m, y_m, way_x_m, way_y_m, plane.radius_m)
        share = min(share, share_of_way(near_of(agents, i, number), way, work.sieve.judged))
    return share


@compiled_inline
def share_of_way(near: Near, way: Way, judged: Judged) -> float:
    """Share of a way up to the first obstacle of a layer that is met; infinity if none is."""
    share = math.inf
    if near.counts[BOXES]:
        share = min(share, _box_share(near.boxes, near.counts[BOXES], way, judged))
    if near.counts[TURNED]:
        share = min(share, _turned_share(near.turned, near.counts[TURNED], way, judged))
    if near.counts[DISCS]:
        share = min(share, _disc_share(near.discs, near.counts[DISCS], way, judged))
    if near.counts[SIDES]:
        share = min(share, _side_share(near.sides, near.counts[SIDES], way, judged))
    return share


@compiled_inline
def _box_share(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    """Share of a way up to the first box; infinity without a test of each if none is near."""
    if not boxes_touched(near, count, around(way), judged):
        return math.inf
    return _first_box(near, count, way, judged)


@compiled_inline
def _turned_share(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    if not turned_touched(near, count, around(way), judged):
        return math.inf
    return _first_turned(near, count, way, judged)


@compiled_inline
def _disc_share(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    if not discs_touched(near, count, around(way), judged):
        return math.inf
    return _first_disc(near, count, way, judged)


@compiled_inline
def _side_share(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    if not sides_touched(near, count, around(way), judged):
        return math.inf
    return _first_side(near, count, way, judged)


@compiled_inner
def _first_box(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    """Share of the way up to the first of the boxes that are marked in `judged`."""
    ahead, left, length_m = _direction(way)
    first_m = math.inf
    for k in range(count):
        at = np.uintp(k)
        if judged[at]:
            x, y = np.float64(near[BOX_X, at]) - way.x_m, np.float64(near[BOX_Y, at]) - way.y_m
            length, width = near[BOX_HALF_LENGTH, at], near[BOX_HALF_WIDTH, at]
            met_m = _meets_grown_box_m(x, y, length, width, ahead, left, way.radius_m)
            first_m = min(first_m, met_m)
    return _share(first_m, length_m)


@compiled_inner
def _first_turned(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    ahead, left, length_m = _direction(way)
    first_m = math.inf
    for k in range(count):
        at = np.uintp(k)
        if judged[at]:
            x, y = np.float64(near[BOX_X, at]) - way.x_m, np.float64(near[BOX_Y, at]) - way.y_m
            cos, sin = np.float64(near[BOX_COS, at]), np.float64(near[BOX_SIN, at])
            length, width = near[BOX_HALF_LENGTH, at], near[BOX_HALF_WIDTH, at]
            along, across = turned_back(x, y, cos, sin)
            own_ahead, own_left = turned_back(ahead, left, cos, sin)
            met_m = _meets_grown_box_m(
                along, across, length, width, own_ahead, own_left, way.radius_m
            )
            first_m = min(first_m, met_m)
    return _share(first_m, length_m)


@compiled_inner
def _meets_grown_box_m(
    x: float,
    y: float,
    half_length: np.float32,
    half_width: np.float32,
    ahead: float,
    left: float,
    radius_m: float,
) -> float:
    """Length up to a box with round corners: a longer box, a wider one, a disc at each corner."""
    per_ahead, per_left = reciprocal(ahead, _STEEPEST), reciprocal(left, _STEEPEST)
    length, width = np.float64(half_length), np.float64(half_width)
    if radius_m == 0.0:
        return float(meets_box_m(x, y, length, width, per_ahead, per_left))
    longer = meets_box_m(x, y, length + radius_m, width, per_ahead, per_left)
    wider = meets_box_m(x, y, length, width + radius_m, per_ahead, per_left)
    first_m = min(longer, wider)
    for corner in range(4):
        corner_x = x + (length if corner & 1 else -length)
        corner_y = y + (width if corner & 2 else -width)
        first_m = min(first_m, meets_disc_m(corner_x, corner_y, radius_m, ahead, left))
    return float(first_m)


@compiled_inner
def _first_disc(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    ahead, left, length_m = _direction(way)
    first_m = math.inf
    for k in range(count):
        at = np.uintp(k)
        if judged[at]:
            x, y = np.float64(near[DISC_X, at]) - way.x_m, np.float64(near[DISC_Y, at]) - way.y_m
            radius_m = np.float64(near[DISC_RADIUS, at]) + way.radius_m
            first_m = min(first_m, meets_disc_m(x, y, radius_m, ahead, left))
    return _share(first_m, length_m)


@compiled_inner
def _first_side(near: Floats32, count: int, way: Way, judged: Judged) -> float:
    ahead, left, length_m = _direction(way)
    radius_m, first_m = way.radius_m, math.inf
    for k in range(count):
        at = np.uintp(k)
        if not judged[at]:
            continue
        x, y = np.float64(near[SIDE_X, at]) - way.x_m, np.float64(near[SIDE_Y, at]) - way.y_m
        side_x, side_y = np.float64(near[SIDE_AHEAD, at]), np.float64(near[SIDE_LEFT, at])
        if radius_m > 0.0:
            first_m = min(first_m, meets_disc_m(x, y, radius_m, ahead, left))
            per_length = radius_m / max(math.hypot(side_x, side_y), _STEEPEST)
            x, y = x + side_y * per_length, y - side_x * per_length
        first_m = min(first_m, meets_side_m(x, y, side_x, side_y, ahead, left))
    return _share(first_m, length_m)


@compiled_inline
def _direction(way: Way) -> tuple[float, float, float]:
    """Unit vector of a step, and its length; (1, 0) for a step of length 0."""
    length_m = math.hypot(way.ahead_m, way.left_m)
    if length_m > 0.0:
        return way.ahead_m / length_m, way.left_m / length_m, length_m
    return 1.0, 0.0, 0.0


@compiled_inline
def _share(met_m: float, length_m: float) -> float:
    if met_m > length_m:
        return math.inf
    return met_m / length_m if length_m > 0.0 else 0.0
