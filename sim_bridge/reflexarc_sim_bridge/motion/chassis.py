"""How a body moves: its chassis follows the commands with lag and slip, in straight steps.

Speeds follow a command with a first-order lag and bounded accelerations, and slip: at each step
every speed is off by a random share of it, which is the larger the shorter a step is, so that after
a given time the way is off as much (`worlds/stepping.py`). Within a step of Δt the heading turns by
ω Δt; the body goes the chord of that arc, (v, u) Δt · sin(ωΔt/2) / (ωΔt/2), at the middle heading.

A contact ends the step there: the agent has gone only so far. (Had it kept the whole step's
distance, a blind agent would score about 2 % too little.) `ghost` agents go on through the
obstacle, and can touch again once they are clear.
"""

import math

from reflexarc_sim_bridge.arrays.layout import GHOST, OPEN, Params, Row
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.motion.contact import free_share
from reflexarc_sim_bridge.motion.overlap import touches
from reflexarc_sim_bridge.motion.placing import set_place
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_part
from reflexarc_sim_bridge.native.function_pointers import call
from reflexarc_sim_bridge.native.splitmix64 import normal
from reflexarc_sim_bridge.obstacles.gathering import keep_near
from reflexarc_sim_bridge.obstacles.keys import draw


@compiled_part
def step_agent(
    params: Params,
    work: Workspace,
    i: int,
    linear_mps: float,
    lateral_mps: float,
    angular_radps: float,
) -> bool:
    """Move agent `i` for one step of its world.

    Returns:
        Whether it met an obstacle. It then stands at another place of the same x, unless the world
        lets it pass through.
    """
    state = params.agents.state[i]
    plane = params.world.planes[state.world]
    ahead_m, left_m = _way_m(plane, state, linear_mps, lateral_mps, angular_radps)
    if plane.edges == OPEN:
        y_m = state.cell_y * plane.chunk_width_m + state.y_m
        left_m = min(max(y_m + left_m, 0.0), plane.width_m) - y_m
    share = math.inf if state.is_inside else free_share(params, work, i, ahead_m, left_m)
    met, goes_on = share <= 1.0, plane.after_contact == GHOST
    if met and not goes_on:
        ahead_m, left_m = ahead_m * share, 0.0
    state.steps += 1
    state.distance_m += ahead_m
    state.contacts += met
    set_place(plane, state, state.cell_x, state.x_m + ahead_m, state.cell_y, state.y_m + left_m)
    if met and not goes_on:
        state.due = 0  # what a slow sensor sent last is of another place
        call(work.parts.put, (params, work, i))
    else:
        keep_near(params, work, i)
    if goes_on and (met or state.is_inside):
        state.is_inside = touches(params, i)
    return met


@compiled_part
def _way_m(
    plane: Row, state: Row, linear_mps: float, lateral_mps: float, angular_radps: float
) -> tuple[float, float]:
    """Turn, and say how far a step leads along x and y."""
    state.linear_mps = _followed(plane, state.linear_mps, linear_mps, plane.most_linear_mps)
    state.lateral_mps = _followed(plane, state.lateral_mps, lateral_mps, plane.most_linear_mps)
    state.angular_radps = _followed(
        plane, state.angular_radps, angular_radps, plane.most_angular_radps
    )
    ahead_m = state.linear_mps * plane.dt_s
    left_m = state.lateral_mps * plane.dt_s
    turned_rad = state.angular_radps * plane.dt_s
    if plane.slip > 0.0:
        ahead_m *= 1.0 + plane.slip * normal(draw(plane, state))
        left_m *= 1.0 + plane.slip * normal(draw(plane, state))
        turned_rad *= 1.0 + plane.slip * normal(draw(plane, state))
    if turned_rad == 0.0 and state.heading_rad == 0.0:
        return ahead_m, left_m
    middle_rad = state.heading_rad + 0.5 * turned_rad
    state.heading_rad = _wrapped_rad(state.heading_rad + turned_rad)
    chord = math.sin(0.5 * turned_rad) / (0.5 * turned_rad) if turned_rad != 0.0 else 1.0
    cos, sin = chord * math.cos(middle_rad), chord * math.sin(middle_rad)
    return ahead_m * cos - left_m * sin, ahead_m * sin + left_m * cos


@compiled_inline
def _followed(plane: Row, now: float, wanted: float, most: float) -> float:
    change = (wanted - now) * plane.follow
    return now + float(min(max(change, -most), most))


@compiled_inline
def _wrapped_rad(angle_rad: float) -> float:
    return angle_rad - 2.0 * math.pi * math.floor(angle_rad / (2.0 * math.pi) + 0.5)
