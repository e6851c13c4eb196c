"""How a body moves, what it runs into, and where it goes on after that.

A step is a straight segment (forward·Δt, aside·Δt), found to meet an obstacle or not with the
same geometry that the rays see. A contact ends the step there: the agent has gone only so far,
and goes on at the same x at a y drawn uniformly among the free places, with no condition on
what lies ahead of it. (Had it kept the whole step's distance, a blind agent would score about 2 %
too little; had it asked for headway, 0.57 of 2ρR.) Places are drawn from the agent's own stream.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.chunks import (
    chunk_count,
    chunk_key,
    obstacle_size_m,
    obstacle_x_m,
    obstacle_y_m,
    random_place,
)
from reflexarc_sim_bridge.compiled import compiled
from reflexarc_sim_bridge.geometry import meets_disc_m, meets_rectangle_m
from reflexarc_sim_bridge.params import (
    CHUNK_M,
    NEAR_HALF_LENGTH,
    NEAR_HALF_WIDTH,
    NEAR_ROUND,
    NEAR_X,
    NEAR_Y,
    Agents,
    WorldParams,
)

_STEEPEST = 1e-12
# A place this close to an obstacle is not free: the face just run into counts as taken.
_TOUCHING_M = 1e-9
# So many draws miss every free place of a half-covered line once in 1e19; a line that refuses
# them all is taken for blocked, and the agent goes on a little farther ahead.
_PLACE_DRAWS = 64
_PAST_BLOCKED_M = 0.1


@compiled
def free_share(
    near: npt.NDArray[np.float64],
    count: int,
    x_m: float,
    y_m: float,
    forward_m: float,
    aside_m: float,
) -> float:
    """Share of a straight step up to the first obstacle that it meets, infinity if none.

    Args:
        near: obstacles, rows NEAR_*: (6, capacity).
        count: how many columns of `near` hold one.
        x_m: where the step begins.
        y_m: the same.
        forward_m: how far it goes along x.
        aside_m: how far it goes along y.
    """
    if _boxes_touched(near, count, x_m, y_m, forward_m, aside_m) == 0:
        return math.inf
    length_m = math.hypot(forward_m, aside_m)
    ahead, left = (forward_m / length_m, aside_m / length_m) if length_m > 0.0 else (1.0, 0.0)
    per_ahead, per_left = _reciprocal(ahead), _reciprocal(left)
    nearest_m = math.inf
    for k in range(count):
        x, y = near[NEAR_X, k] - x_m, near[NEAR_Y, k] - y_m
        half_length, half_width = near[NEAR_HALF_LENGTH, k], near[NEAR_HALF_WIDTH, k]
        if near[NEAR_ROUND, k] != 0.0:
            met = meets_disc_m(x, y, half_length, ahead, left)
        else:
            met = meets_rectangle_m(x, y, half_length, half_width, per_ahead, per_left)
        nearest_m = min(nearest_m, float(met))
    if nearest_m > length_m:
        return math.inf
    return nearest_m / length_m if length_m > 0.0 else 0.0


@compiled
def go_to_free_place(world: WorldParams, agents: Agents, i: int) -> None:
    """Put an agent at a free y of its x, all free places being equally likely."""
    seed, lane = agents.seed[i], agents.lane[i]
    while True:
        for _ in range(_PLACE_DRAWS):
            y_m = world.width_m * random_place(world, seed, lane, agents.draws[i])
            agents.draws[i] += np.uint64(1)
            if is_free(world, seed, agents.x_m[i], y_m):
                agents.y_m[i] = y_m
                return
        agents.x_m[i] += _PAST_BLOCKED_M


@compiled
def is_free(world: WorldParams, seed: np.uint64, x_m: float, y_m: float) -> bool:
    """Whether no obstacle covers or touches a place."""
    reach_m = world.half_max_m + _TOUCHING_M
    first, last = math.floor((x_m - reach_m) / CHUNK_M), math.floor((x_m + reach_m) / CHUNK_M)
    for chunk in range(first, last + 1):
        key = chunk_key(world, seed, chunk)
        for j in range(chunk_count(world, key)):
            x = obstacle_x_m(key, chunk, j) - x_m
            if abs(x) <= reach_m and _covers(world, key, j, x, y_m):
                return False
    return True


@compiled
def wrapped(world: WorldParams, y_m: float) -> float:
    """The same place within one period; with open edges the nearest place inside."""
    if world.periodic:
        return y_m - world.width_m * math.floor(y_m / world.width_m)
    return min(max(y_m, 0.0), world.width_m)


@compiled
def _covers(world: WorldParams, key: np.uint64, j: int, x: float, y_m: float) -> bool:
    half_length, half_width, is_disc = obstacle_size_m(world, key, j)
    y = obstacle_y_m(world, key, j) - y_m
    if world.periodic:
        y -= world.width_m * np.rint(y / world.width_m)
    if is_disc:
        return math.hypot(x, y) <= half_width + _TOUCHING_M
    return abs(x) <= half_length + _TOUCHING_M and abs(y) <= half_width + _TOUCHING_M


@compiled
def _boxes_touched(
    near: npt.NDArray[np.float64],
    count: int,
    x_m: float,
    y_m: float,
    forward_m: float,
    aside_m: float,
) -> int:
    """How many obstacles' bounding boxes meet the step's: nearly always none, and cheap to say."""
    middle_x, reach_x = x_m + 0.5 * forward_m, 0.5 * abs(forward_m) + _TOUCHING_M
    middle_y, reach_y = y_m + 0.5 * aside_m, 0.5 * abs(aside_m) + _TOUCHING_M
    touched = 0
    for k in range(count):
        along = abs(near[NEAR_X, k] - middle_x) <= near[NEAR_HALF_LENGTH, k] + reach_x
        across = abs(near[NEAR_Y, k] - middle_y) <= near[NEAR_HALF_WIDTH, k] + reach_y
        touched += along & across
    return touched


@compiled
def _reciprocal(component: float) -> float:
    return 1.0 / math.copysign(max(abs(component), _STEEPEST), component)
