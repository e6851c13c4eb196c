"""The shades that rays see on striped surfaces, worked out where each of them has met one."""

from typing import NamedTuple

import numpy as np

from reflexarc_sim_bridge.arrays.layout import (
    BOX_COS,
    BOX_HALF_LENGTH,
    BOX_HALF_WIDTH,
    BOX_SIN,
    DISC_RADIUS,
    DISCS,
    PLACE_X,
    PLACE_Y,
    SIDES,
    TURNED,
    Floats32,
    Near,
    Params,
    Row,
)
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.obstacles.geometry import turned_back
from reflexarc_sim_bridge.obstacles.keys import layer_key
from reflexarc_sim_bridge.obstacles.near_lists import near_of, place_in_layer_m
from reflexarc_sim_bridge.obstacles.stripes import (
    contrast_of_wall,
    place_on_box_m,
    place_on_disc_m,
    place_on_wall_m,
    read_mark,
    stripe_at,
)
from reflexarc_sim_bridge.worlds.grid import CHUNK_M


class Met(NamedTuple):
    """Where a ray has met a surface, in the frame of its layer."""

    x_m: float
    """From the corner of the agent's cell."""
    y_m: float
    corner_x_m: float
    """That corner."""
    time_s: float


@compiled_inner
def paint_stripes(
    params: Params, work: Workspace, i: int, aside_x_m: float, aside_y_m: float
) -> None:
    """Put colours in place of the marks of striped surfaces in `work.paint`.

    Args:
        params: the simulation.
        work: what the sub-rays of an eye have met.
        i: whose eye.
        aside_x_m: where it is, from the agent's middle, in the world's frame.
        aside_y_m: the same.
    """
    agents, state = params.agents, params.agents.state[i]
    plane = params.world.planes[state.world]
    for number in range(plane.layers):
        layer, cell = params.world.layers[state.world, number], agents.layer_cells[i, number]
        if layer.stripes_m == 0.0:
            continue
        key, near = layer_key(plane.stream, state.seed, number), near_of(agents, i, number)
        eye_x_m, eye_y_m = place_in_layer_m(plane, layer, state, cell)
        eye_x_m, eye_y_m = eye_x_m + aside_x_m, eye_y_m + aside_y_m
        corner_x_m, time_s = cell[0] * CHUNK_M, state.steps * plane.dt_s
        for ray in range(work.paint.size):
            own, kind, entry = read_mark(work.paint[ray])
            if own == number:
                x_m = eye_x_m + np.float64(work.distance_m[ray]) * np.float64(work.ahead[ray])
                y_m = eye_y_m + np.float64(work.distance_m[ray]) * np.float64(work.left[ray])
                met = Met(x_m, y_m, corner_x_m, time_s)
                work.paint[ray] = _shade_met(layer, key, near, kind, entry, met)


@compiled_inline
def _shade_met(layer: Row, key: np.uint64, near: Near, kind: int, entry: int, met: Met) -> int:
    if kind == SIDES:
        place_m = place_on_wall_m(layer, entry, met.corner_x_m + met.x_m, met.time_s)
        return stripe_at(layer, key, entry, place_m, contrast_of_wall(layer, entry))
    if kind == DISCS:
        x_m, y_m = _from_middle_m(near.discs, entry, met)
        place_m = place_on_disc_m(x_m, y_m, np.float64(near.discs[DISC_RADIUS, entry]))
        return stripe_at(layer, key, _surface_of(near.discs, entry), place_m, 1.0)
    if kind == TURNED:
        x_m, y_m = _from_middle_m(near.turned, entry, met)
        cos, sin = near.turned[BOX_COS, entry], near.turned[BOX_SIN, entry]
        x_m, y_m = turned_back(x_m, y_m, np.float64(cos), np.float64(sin))
        return _shade_box(layer, key, near.turned, entry, x_m, y_m)
    x_m, y_m = _from_middle_m(near.boxes, entry, met)
    return _shade_box(layer, key, near.boxes, entry, x_m, y_m)


@compiled_inline
def _shade_box(
    layer: Row, key: np.uint64, rows: Floats32, entry: int, x_m: float, y_m: float
) -> int:
    half_length_m = np.float64(rows[BOX_HALF_LENGTH, entry])
    half_width_m = np.float64(rows[BOX_HALF_WIDTH, entry])
    place_m = place_on_box_m(x_m, y_m, half_length_m, half_width_m)
    return stripe_at(layer, key, _surface_of(rows, entry), place_m, 1.0)


@compiled_inline
def _from_middle_m(rows: Floats32, entry: int, met: Met) -> tuple[float, float]:
    return met.x_m - np.float64(rows[PLACE_X, entry]), met.y_m - np.float64(rows[PLACE_Y, entry])


@compiled_inline
def _surface_of(rows: Floats32, entry: int) -> int:
    return int(rows[rows.shape[0] - 1, entry])
