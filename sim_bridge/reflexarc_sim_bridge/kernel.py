"""The compiled step of agents in their worlds: sense, move, and keep near what can be met.

`sense_agent` and `step_agent` treat one agent and are made to be called from other compiled
loops; `sense_all` and `step_all` treat all, in parallel. Whatever an agent does touches its own
row only, so the bits are the same on any number of threads.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.chunks import (
    chunk_count,
    chunk_key,
    obstacle_colour,
    obstacle_size_m,
    obstacle_x_m,
    obstacle_y_m,
)
from reflexarc_sim_bridge.compiled import compiled, compiled_parallel, prange
from reflexarc_sim_bridge.motion import free_share, go_to_free_place, wrapped
from reflexarc_sim_bridge.params import (
    CELL_M,
    CHUNK_M,
    NEAR_COLOUR,
    NEAR_HALF_LENGTH,
    NEAR_HALF_WIDTH,
    NEAR_ROUND,
    NEAR_X,
    NEAR_Y,
    Agents,
    EyeParams,
    WorldParams,
)
from reflexarc_sim_bridge.vision import look, shade_all

__all__ = [
    "Agents",
    "EyeParams",
    "WorldParams",
    "place_all",
    "sense_agent",
    "sense_all",
    "step_agent",
    "step_all",
]


@compiled
def sense_agent(
    world: WorldParams,
    eye: EyeParams,
    agents: Agents,
    i: int,
    retina_out: npt.NDArray[np.uint8],
) -> None:
    """What agent `i` sees now, grey, one eye, one frame: `retina_out` (rays,) is filled."""
    distance_m, colour = agents.ray_distance_m[i], agents.ray_colour[i]
    look(
        eye, agents.near[i], agents.near_count[i], agents.x_m[i], agents.y_m[i], distance_m, colour
    )
    shade_all(eye.range_m, eye.nearness, distance_m, colour, retina_out)


@compiled
def step_agent(
    world: WorldParams, agents: Agents, i: int, linear_mps: float, lateral_mps: float
) -> bool:
    """Move agent `i` for one step of the world.

    Returns:
        Whether it met an obstacle. It then stands at another place of the same x.
    """
    x_m, y_m = agents.x_m[i], agents.y_m[i]
    forward_m, aside_m = linear_mps * world.dt_s, lateral_mps * world.dt_s
    if not world.periodic:
        aside_m = wrapped(world, y_m + aside_m) - y_m
    share = free_share(agents.near[i], agents.near_count[i], x_m, y_m, forward_m, aside_m)
    met = share <= 1.0
    if met:
        forward_m *= share
    agents.x_m[i] = x_m + forward_m
    agents.distance_m[i] += forward_m
    if met:
        agents.contacts[i] += 1
        go_to_free_place(world, agents, i)
    else:
        agents.y_m[i] = wrapped(world, y_m + aside_m)
    _keep_near(world, agents, i)
    return met


@compiled_parallel
def sense_all(
    world: WorldParams, eye: EyeParams, agents: Agents, retinas_out: npt.NDArray[np.uint8]
) -> None:
    """What every agent sees: `retinas_out` (n, rays) is filled."""
    for i in prange(agents.x_m.size):
        sense_agent(world, eye, agents, i, retinas_out[i])


@compiled_parallel
def step_all(
    world: WorldParams,
    agents: Agents,
    linear_mps: npt.NDArray[np.float64],
    lateral_mps: npt.NDArray[np.float64],
    actions: npt.NDArray[np.int64],
    met_out: npt.NDArray[np.bool_],
) -> None:
    """Move every agent: speeds are per action (actions,), `met_out` (n,) is filled."""
    for i in prange(agents.x_m.size):
        action = actions[i]
        met_out[i] = step_agent(world, agents, i, linear_mps[action], lateral_mps[action])


@compiled
def place_all(world: WorldParams, agents: Agents) -> None:
    """Put every agent at a free place of its x and gather what is near.

    Once a simulation, so one thread will do: a parallel loop takes 5 s more to compile.
    """
    for i in range(agents.x_m.size):
        _place_agent(world, agents, i)


@compiled
def _place_agent(world: WorldParams, agents: Agents, i: int) -> None:
    go_to_free_place(world, agents, i)
    agents.cell_x[i] = math.floor(agents.x_m[i] / CELL_M)
    agents.cell_y[i] = math.floor(agents.y_m[i] / CELL_M)
    _gather_near(world, agents, i)


@compiled
def _keep_near(world: WorldParams, agents: Agents, i: int) -> None:
    """Gather anew when the agent has entered another cell."""
    cell_x = math.floor(agents.x_m[i] / CELL_M)
    cell_y = math.floor(agents.y_m[i] / CELL_M)
    if cell_x != agents.cell_x[i] or cell_y != agents.cell_y[i]:
        agents.cell_x[i], agents.cell_y[i] = cell_x, cell_y
        _gather_near(world, agents, i)


@compiled
def _gather_near(world: WorldParams, agents: Agents, i: int) -> None:
    """List every obstacle that can be seen or met from anywhere in the agent's cell."""
    seed, near, count = agents.seed[i], agents.near[i], 0
    back_m = agents.cell_x[i] * CELL_M - world.behind_m - world.half_max_m
    front_m = (agents.cell_x[i] + 1) * CELL_M + world.ahead_m + world.half_max_m
    right_m = agents.cell_y[i] * CELL_M - world.aside_m - world.half_max_m
    left_m = (agents.cell_y[i] + 1) * CELL_M + world.aside_m + world.half_max_m
    for chunk in range(math.floor(back_m / CHUNK_M), math.floor(front_m / CHUNK_M) + 1):
        key, first = chunk_key(world, seed, chunk), count
        for j in range(chunk_count(world, key)):
            x_m, y_m = obstacle_x_m(key, chunk, j), obstacle_y_m(world, key, j)
            along = (back_m <= x_m) & (x_m <= front_m)
            count = _list_images(world, near, count, j, x_m, y_m, along, right_m, left_m)
        for k in range(first, count):
            _fill_in(world, near, k, key)
    agents.near_count[i] = count


@compiled
def _list_images(
    world: WorldParams,
    near: npt.NDArray[np.float64],
    count: int,
    j: int,
    x_m: float,
    y_m: float,
    along: bool,
    right_m: float,
    left_m: float,
) -> int:
    """List an obstacle's place and number, once for each period in which it lies in the box.

    Written first and counted after: half of the obstacles are out, and no branch foresees which.
    """
    period_m = world.width_m if world.periodic else math.inf
    if world.periodic:
        y_m += period_m * np.ceil((right_m - y_m) / period_m)
    inside = along & (right_m <= y_m) & (y_m <= left_m)
    while True:
        near[NEAR_X, count], near[NEAR_Y, count], near[NEAR_COLOUR, count] = x_m, y_m, j
        count = min(count + inside, near.shape[1] - 1)
        y_m += period_m
        if not (inside & (y_m <= left_m)):
            return count


@compiled
def _fill_in(world: WorldParams, near: npt.NDArray[np.float64], k: int, key: np.uint64) -> None:
    """Size, kind and colour of an obstacle whose number lies in its row of colours."""
    j = int(near[NEAR_COLOUR, k])
    half_length_m, half_width_m, is_disc = obstacle_size_m(world, key, j)
    near[NEAR_HALF_LENGTH, k], near[NEAR_HALF_WIDTH, k] = half_length_m, half_width_m
    near[NEAR_ROUND, k] = 1.0 if is_disc else 0.0
    near[NEAR_COLOUR, k] = obstacle_colour(world, key, j)
