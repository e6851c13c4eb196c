"""Where an agent is put: at the start, after a contact, and when it crosses the border of its cell.

All free places of its x are equally likely, with no condition on what lies ahead. (Had it asked
for headway, a blind agent would score 0.57 of 2ρR.) Places are drawn from the agent's own stream.
"""

import math

from reflexarc_sim_bridge.arrays.layout import OPEN, PERIODIC, UNBOUNDED, Params, Row, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.motion.overlap import touches
from reflexarc_sim_bridge.native.decorators import compiled_called, compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import uniform
from reflexarc_sim_bridge.obstacles.gathering import keep_near
from reflexarc_sim_bridge.obstacles.keys import draw, layer_key
from reflexarc_sim_bridge.obstacles.kinds.corridor import corridor_line_m
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

# So many draws miss every free place of a half-covered line once in 1e19. Where all of them miss,
# the line is taken for blocked, and the agent is put a little farther ahead.
_PLACE_DRAWS = 64
_PAST_BLOCKED_M = 0.1


@compiled_called
def go_to_free_place(params: Params, work: Workspace, i: int) -> None:
    """Put an agent at a free y of its x, all free places being equally likely.

    Args:
        params: the simulation.
        work: scratch.
        i: which agent.
    """
    state = params.agents.state[i]
    plane = params.world.planes[state.world]
    while True:
        low_m, high_m = _strip_m(params.world, plane, state)
        for _ in range(_PLACE_DRAWS):
            y_m = low_m + (high_m - low_m) * uniform(draw(plane, state))
            set_place(plane, state, state.cell_x, state.x_m, 0, y_m)
            keep_near(params, work, i)
            if not touches(params, i):
                return
        set_place(plane, state, state.cell_x, state.x_m + _PAST_BLOCKED_M, state.cell_y, state.y_m)


@compiled_inline
def set_place(plane: Row, state: Row, cell_x: int, x_m: float, cell_y: int, y_m: float) -> None:
    """Put an agent at a place, given by a cell and an offset that may lie outside of it.

    Across a periodic world it is the same place within the period, across an open one the nearest
    place inside.
    """
    side_m, steps_x = plane.chunk_width_m, math.floor(x_m / CHUNK_M)
    if plane.edges == OPEN:
        y_m = min(max(y_m, -cell_y * side_m), plane.width_m - cell_y * side_m)
    steps_y = math.floor(y_m / side_m)
    state.cell_x, state.x_m = cell_x + steps_x, x_m - steps_x * CHUNK_M
    state.cell_y, state.y_m = cell_y + steps_y, y_m - steps_y * side_m
    if plane.edges == PERIODIC and not 0 <= state.cell_y < plane.across:
        state.cell_y %= plane.across


@compiled_inner
def _strip_m(world: WorldTables, plane: Row, state: Row) -> tuple[float, float]:
    """Lowest and highest lateral place at which an agent may be put."""
    if plane.corridor >= 0:
        layer = world.layers[state.world, plane.corridor]
        key = layer_key(plane.stream, state.seed, plane.corridor)
        middle_m = corridor_line_m(layer, key, state.cell_x * CHUNK_M + state.x_m)
        return middle_m - layer.half_width_m, middle_m + layer.half_width_m
    if plane.edges == UNBOUNDED:
        middle_m = state.cell_y * plane.chunk_width_m + state.y_m
        return middle_m - 0.5 * plane.width_m, middle_m + 0.5 * plane.width_m
    return 0.0, plane.width_m
