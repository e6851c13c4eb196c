"""Whether a body covers or touches an obstacle where it stands."""

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
    SIDE_AHEAD,
    SIDE_LEFT,
    SIDE_X,
    SIDE_Y,
    SIDES,
    TURNED,
    Floats32,
    Params,
)
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.obstacles.geometry import turned_back
from reflexarc_sim_bridge.obstacles.near_lists import near_of, place_in_layer_m

TOUCHING_M = 1e-6
"""This close counts as touching: near places are float32 within some metres."""

_SHORTEST_M2 = 1e-12


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
        near = near_of(agents, i, number)
        if (
            _in_box(near.boxes, near.counts[BOXES], x_m, y_m, radius_m)
            or _in_turned(near.turned, near.counts[TURNED], x_m, y_m, radius_m)
            or _in_disc(near.discs, near.counts[DISCS], x_m, y_m, radius_m)
            or _in_polygon(near.sides, near.counts[SIDES], x_m, y_m, radius_m)
        ):
            return True
    return False


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
def _in_turned(near: Floats32, count: int, x_m: float, y_m: float, radius_m: float) -> bool:
    found = 0
    for k in range(count):
        dx, dy = near[BOX_X, k] - x_m, near[BOX_Y, k] - y_m
        along, across = turned_back(dx, dy, near[BOX_COS, k], near[BOX_SIN, k])
        away_x = max(abs(along) - near[BOX_HALF_LENGTH, k], 0.0)
        away_y = max(abs(across) - near[BOX_HALF_WIDTH, k], 0.0)
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
        winding += passes_beside(x, y, end_x, end_y)
        close += squared_distance_m2(x, y, end_x - x, end_y - y) <= radius_m * radius_m
    return winding > 0 or close > 0


@compiled_inline
def passes_beside(x: float, y: float, end_x: float, end_y: float) -> int:
    """1 for a side that passes the origin upwards, on its right along x; −1 for one downwards."""
    if (y <= 0.0) == (end_y <= 0.0):
        return 0
    beside = x * end_y - end_x * y
    return int((beside > 0.0) & (end_y > 0.0)) - int((beside < 0.0) & (end_y <= 0.0))


@compiled_inline
def squared_distance_m2(x: float, y: float, side_x: float, side_y: float) -> float:
    """From the origin to a side that begins at (x, y)."""
    along = -(x * side_x + y * side_y) / max(side_x * side_x + side_y * side_y, _SHORTEST_M2)
    along = min(max(along, 0.0), 1.0)
    dx, dy = x + along * side_x, y + along * side_y
    return dx * dx + dy * dy
