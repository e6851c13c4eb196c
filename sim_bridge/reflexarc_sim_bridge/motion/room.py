"""How much room a body has: to the nearest obstacle around it, and straight ahead.

What is near an agent is what contacts are found by, and the geometry is theirs: the nearest point
of an outline, and the first touch of a body that goes straight on (`contact.py`). Where sides of
the world are open, a body that goes straight on leaves it: nothing is there.
"""

import math
from typing import NamedTuple

from reflexarc_sim_bridge.arrays.layout import (
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
    DRIFT,
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_X,
    SIDE_Y,
    SIDES,
    SWING,
    TURNED,
    Floats32,
    Near,
    Params,
    Row,
)
from reflexarc_sim_bridge.arrays.workspace import Judged, Workspace
from reflexarc_sim_bridge.motion.broad_phase import Way
from reflexarc_sim_bridge.motion.contact import share_of_way
from reflexarc_sim_bridge.motion.overlap import passes_beside, squared_distance_m2
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.obstacles.geometry import turned_back
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m, near_of, place_in_layer_m

CHORDS_A_PERIOD = 32
"""A swing is followed along so many straight pieces, which are off by half a percent of it."""
_MOST_CHORDS = 64
_SLOWEST_MPS = 1e-9
"""Relative speeds below count as this one."""


class Line(NamedTuple):
    """How a body goes straight on, from its place in a layer's frame."""

    x_m: float
    y_m: float
    ahead_mps: float
    left_mps: float
    radius_m: float
    until_s: float
    """For how long."""
    farthest_m: float
    """How far, in the layer's frame."""


@compiled_inner
def room_m(params: Params, i: int, range_m: float) -> float:
    """From an agent's outline to the nearest obstacle; 0 in contact.

    Args:
        params: the simulation.
        i: which agent.
        range_m: what is farther from its middle counts as being there.
    """
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane, nearest_m2 = world.planes[state.world], range_m * range_m
    for number in range(plane.layers):
        layer = world.layers[state.world, number]
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        nearest_m2 = min(nearest_m2, _nearest_m2(near_of(agents, i, number), x_m, y_m))
    return float(max(math.sqrt(nearest_m2) - plane.radius_m, 0.0))


@compiled_inner
def free_s(params: Params, work: Workspace, i: int, forward_mps: float, range_m: float) -> float:
    """Time up to the first contact of an agent that goes straight on from now; infinity if none is.

    Of what lies within the range now, and within the time in which the body goes so far. Layers go
    on moving as they do: a drift to the end, a swing along short chords.

    Args:
        params: the simulation.
        work: scratch.
        i: which agent.
        forward_mps: its speed, along its heading.
        range_m: from the body's middle to its outline after the last touch that counts.
    """
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane, first_s = world.planes[state.world], math.inf
    farthest_m = range_m - plane.radius_m
    if forward_mps <= 0.0 or farthest_m <= 0.0:
        return first_s
    until_s = farthest_m / forward_mps
    ahead_mps = forward_mps * math.cos(state.heading_rad)
    left_mps = forward_mps * math.sin(state.heading_rad)
    for number in range(plane.layers):
        layer, near = world.layers[state.world, number], near_of(agents, i, number)
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[i, number])
        line = Line(x_m, y_m, ahead_mps, left_mps, plane.radius_m, until_s, farthest_m)
        now_s = state.steps * plane.dt_s
        first_s = min(first_s, _met_s(near, layer, now_s, line, work.sieve.judged))
    return first_s


@compiled_inner
def _met_s(near: Near, layer: Row, now_s: float, line: Line, judged: Judged) -> float:
    """When a body first meets an obstacle of a layer: chord by chord of its way in that frame."""
    until_s, chord_s = _pieces_s(layer, line)
    now_x, now_y = displacement_m(layer, now_s)
    from_s, way_x_m, way_y_m = 0.0, 0.0, 0.0
    while from_s < until_s and math.hypot(way_x_m, way_y_m) < line.farthest_m:
        to_s = min(from_s + chord_s, until_s)
        to_x, to_y = displacement_m(layer, now_s + to_s)
        ahead_m = line.ahead_mps * to_s - (to_x - now_x) - way_x_m
        left_m = line.left_mps * to_s - (to_y - now_y) - way_y_m
        way = Way(line.x_m + way_x_m, line.y_m + way_y_m, ahead_m, left_m, line.radius_m)
        share = share_of_way(near, way, judged)
        if share <= 1.0:
            return from_s + share * (to_s - from_s)
        from_s, way_x_m, way_y_m = to_s, way_x_m + ahead_m, way_y_m + left_m
    return math.inf


@compiled_inline
def _pieces_s(layer: Row, line: Line) -> tuple[float, float]:
    """For how long a layer is looked at, and in pieces of which length: rest and drift in one."""
    if layer.motion == SWING:
        return line.until_s, max(layer.period_s / CHORDS_A_PERIOD, line.until_s / _MOST_CHORDS)
    ahead_mps, left_mps = line.ahead_mps, line.left_mps
    if layer.motion == DRIFT:
        ahead_mps -= layer.moves_ahead
        left_mps -= layer.moves_left
    speed_mps = max(math.hypot(ahead_mps, left_mps), _SLOWEST_MPS)
    until_s = min(line.until_s, line.farthest_m / speed_mps)
    return until_s, until_s


@compiled_inline
def _nearest_m2(near: Near, x_m: float, y_m: float) -> float:
    """Squared distance from a place to the nearest obstacle of a layer, 0 inside of one."""
    boxes = _to_box_m2(near.boxes, near.counts[BOXES], x_m, y_m)
    turned = _to_turned_m2(near.turned, near.counts[TURNED], x_m, y_m)
    discs = _to_disc_m2(near.discs, near.counts[DISCS], x_m, y_m)
    return min(boxes, turned, discs, _to_polygon_m2(near.sides, near.counts[SIDES], x_m, y_m))


@compiled_inline
def _to_box_m2(near: Floats32, count: int, x_m: float, y_m: float) -> float:
    nearest_m2 = math.inf
    for k in range(count):
        away_x = max(abs(near[BOX_X, k] - x_m) - near[BOX_HALF_LENGTH, k], 0.0)
        away_y = max(abs(near[BOX_Y, k] - y_m) - near[BOX_HALF_WIDTH, k], 0.0)
        nearest_m2 = min(nearest_m2, away_x * away_x + away_y * away_y)
    return nearest_m2


@compiled_inline
def _to_turned_m2(near: Floats32, count: int, x_m: float, y_m: float) -> float:
    nearest_m2 = math.inf
    for k in range(count):
        dx, dy = near[BOX_X, k] - x_m, near[BOX_Y, k] - y_m
        along, across = turned_back(dx, dy, near[BOX_COS, k], near[BOX_SIN, k])
        away_x = max(abs(along) - near[BOX_HALF_LENGTH, k], 0.0)
        away_y = max(abs(across) - near[BOX_HALF_WIDTH, k], 0.0)
        nearest_m2 = min(nearest_m2, away_x * away_x + away_y * away_y)
    return nearest_m2


@compiled_inline
def _to_disc_m2(near: Floats32, count: int, x_m: float, y_m: float) -> float:
    nearest_m = math.inf
    for k in range(count):
        away_m = math.hypot(near[DISC_X, k] - x_m, near[DISC_Y, k] - y_m)
        nearest_m = min(nearest_m, max(away_m - near[DISC_RADIUS, k], 0.0))
    return nearest_m * nearest_m


@compiled_inline
def _to_polygon_m2(near: Floats32, count: int, x_m: float, y_m: float) -> float:
    """0 where the sides wind around the place: see `overlap.touches`."""
    nearest_m2, winding = math.inf, 0
    for k in range(count):
        x, y = near[SIDE_X, k] - x_m, near[SIDE_Y, k] - y_m
        ahead, left = near[SIDE_AHEAD, k], near[SIDE_LEFT, k]
        winding += passes_beside(x, y, x + ahead, y + left)
        # The upright box around most sides is farther than another side.
        along = abs(x + 0.5 * ahead) - 0.5 * abs(ahead)
        across = abs(y + 0.5 * left) - 0.5 * abs(left)
        if max(along, 0.0) ** 2 + max(across, 0.0) ** 2 < nearest_m2:
            nearest_m2 = min(nearest_m2, squared_distance_m2(x, y, ahead, left))
    return 0.0 if winding > 0 else nearest_m2
