"""The world, the eye and the agents as plain numbers and arrays: what compiled code is given.

The three are named tuples, so that any other compiled loop (the trainer's) can carry them. One
agent's work writes to its own row of `Agents` and to nothing else: the same bits on any number of
threads.

Near obstacles: the plane is cut into square cells of `CELL_M`. Beside an agent lie the obstacles
that it could see or meet from anywhere in its cell. The list is a function of seed and cell
alone, is rebuilt when the agent enters another cell, and so costs the same after a metre or a
thousand kilometres.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract, RetinaSpec, Shading
from reflexarc_runtime.retina import ray_bearing_rad
from reflexarc_sim_bridge.worlds import Discs, Edges, Shape, World

CELL_M = 2.0
CHUNK_M = 2.5
"""Length of a chunk along x; it spans the whole width of the world."""

# Columns of `Agents.near`.
NEAR_X, NEAR_Y, NEAR_HALF_LENGTH, NEAR_HALF_WIDTH, NEAR_ROUND, NEAR_COLOUR = range(6)
NEAR_COLUMNS = 6

# Columns of `WorldParams.shapes`.
SHAPE_UP_TO, SHAPE_ROUND, SHAPE_WIDTH_LOW, SHAPE_WIDTH_HIGH, SHAPE_LENGTH_LOW, SHAPE_LENGTH_HIGH = (
    range(6)
)

_STEEPEST = 1e-9
"""Direction components below this are taken for this: a finite slope in place of a division by 0."""


class WorldParams(NamedTuple):
    """A world, compiled. Lengths in metres."""

    width_m: float
    periodic: bool
    dt_s: float
    stream: int
    count_cdf: npt.NDArray[np.float64]
    """Cumulative Poisson probabilities of the number of obstacles in a chunk: (k,)."""
    shapes: npt.NDArray[np.float64]
    """One row a kind, columns SHAPE_*: (kinds, 6)."""
    colour_low: float
    colour_high: float
    half_max_m: float
    """No obstacle reaches farther from its centre, along x or y."""
    ahead_m: float
    """How far ahead of an agent anything can be seen or met; behind and aside alike."""
    behind_m: float
    aside_m: float


class EyeParams(NamedTuple):
    """One eye, compiled. Arrays over rays, float32, ray 0 the leftmost."""

    range_m: float
    nearness: bool
    behind_m: float
    """How far behind the agent the eye sees."""
    ahead: npt.NDArray[np.float32]
    """Direction of each ray, x part (cosine of its bearing): (rays,)."""
    left: npt.NDArray[np.float32]
    """Direction of each ray, y part (sine of its bearing): (rays,)."""
    per_ahead: npt.NDArray[np.float32]
    """1 / ahead, finite: (rays,)."""
    per_left: npt.NDArray[np.float32]
    """1 / left, finite: (rays,)."""


class Agents(NamedTuple):
    """Everything that changes, one row an agent."""

    x_m: npt.NDArray[np.float64]
    y_m: npt.NDArray[np.float64]
    seed: npt.NDArray[np.uint64]
    """Seed of the agent's world: (n,)."""
    lane: npt.NDArray[np.uint64]
    """Tells agents of one world apart: each has its own stream of random places: (n,)."""
    draws: npt.NDArray[np.uint64]
    """Random places drawn so far: (n,)."""
    distance_m: npt.NDArray[np.float64]
    """Progress along x: (n,)."""
    contacts: npt.NDArray[np.int64]
    """Contacts so far: (n,)."""
    cell_x: npt.NDArray[np.int64]
    cell_y: npt.NDArray[np.int64]
    near_count: npt.NDArray[np.int64]
    near: npt.NDArray[np.float64]
    """Obstacles near the agent's cell, columns NEAR_*, y beside the agent: (n, capacity, 6)."""
    ray_distance_m: npt.NDArray[np.float32]
    """Of the last look; the range where nothing was met: (n, rays)."""
    ray_colour: npt.NDArray[np.float32]
    """Of the last look; 0 where nothing was met: (n, rays)."""


def world_params(world: World, contract: PolicyContract) -> WorldParams:
    """A world for the agents that a contract describes: it says how far they see and move."""
    step_m = world.dt_s * _fastest_mps(contract)
    range_m = contract.retina.range_m
    low, high = world.colour
    return WorldParams(
        width_m=world.width_m,
        periodic=world.edges is Edges.PERIODIC,
        dt_s=world.dt_s,
        stream=world.stream,
        count_cdf=_poisson_cdf(world.density_per_m2 * world.width_m * CHUNK_M),
        shapes=_shape_table(world.shapes),
        colour_low=low,
        colour_high=high,
        half_max_m=world.longest_m / 2,
        ahead_m=max(range_m, step_m),
        behind_m=max(_behind_m(contract.retina), step_m),
        aside_m=max(range_m, step_m),
    )


def eye_params(spec: RetinaSpec) -> EyeParams:
    """One eye of a retina specification."""
    bearings = [ray_bearing_rad(ray, spec.rays, spec.fov_rad) for ray in range(spec.rays)]
    ahead, left = np.cos(bearings), np.sin(bearings)
    return EyeParams(
        range_m=spec.range_m,
        nearness=spec.shading is Shading.NEARNESS,
        behind_m=_behind_m(spec),
        ahead=ahead.astype(np.float32),
        left=left.astype(np.float32),
        per_ahead=_reciprocal(ahead),
        per_left=_reciprocal(left),
    )


def agents_at_zero(
    seeds: npt.NDArray[np.uint64], world: World, params: WorldParams, rays: int
) -> Agents:
    """Agents that are nowhere yet; `kernel.place_all` puts them into their worlds."""
    n = len(seeds)
    return Agents(
        x_m=np.zeros(n),
        y_m=np.zeros(n),
        seed=seeds.astype(np.uint64),
        lane=_lanes(seeds),
        draws=np.zeros(n, np.uint64),
        distance_m=np.zeros(n),
        contacts=np.zeros(n, np.int64),
        cell_x=np.zeros(n, np.int64),
        cell_y=np.zeros(n, np.int64),
        near_count=np.zeros(n, np.int64),
        near=np.zeros((n, _near_capacity(world, params), NEAR_COLUMNS)),
        ray_distance_m=np.zeros((n, rays), np.float32),
        ray_colour=np.zeros((n, rays), np.float32),
    )


def _fastest_mps(contract: PolicyContract) -> float:
    return max(max(abs(a.linear_mps), abs(a.lateral_mps)) for a in contract.actions)


def _behind_m(spec: RetinaSpec) -> float:
    """A ray at bearing φ reaches range · (−cos φ) behind; within ±90° none does."""
    outermost_rad = ray_bearing_rad(0, spec.rays, spec.fov_rad)
    return spec.range_m * max(0.0, -math.cos(outermost_rad))


def _reciprocal(component: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    away_from_0 = np.copysign(np.maximum(np.abs(component), _STEEPEST), component)
    return (1.0 / away_from_0).astype(np.float32)


def _poisson_cdf(mean: float) -> npt.NDArray[np.float64]:
    """P(count ≤ k) for k = 0, 1, … until the rest is below the resolution of a draw, 2⁻⁵³."""
    last = math.ceil(mean + 10 * math.sqrt(mean) + 20)
    log_p = [k * math.log(mean) - mean - math.lgamma(k + 1) for k in range(last)] if mean else [0.0]
    return np.minimum(np.cumsum(np.exp(log_p)), 1.0)


def _shape_table(shapes: tuple[Shape, ...]) -> npt.NDArray[np.float64]:
    up_to = np.cumsum([shape.share for shape in shapes])
    rows = [_shape_row(shape) for shape in shapes]
    return np.column_stack([up_to / up_to[-1], np.array(rows)])


def _shape_row(shape: Shape) -> tuple[float, ...]:
    if isinstance(shape, Discs):
        low_m, high_m = shape.radius_m
        return (1.0, 2 * low_m, 2 * high_m, 2 * low_m, 2 * high_m)
    return (0.0, *shape.width_m, *shape.length_m)


def _lanes(seeds: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """How many earlier agents have the same seed: (n,)."""
    seen: dict[int, int] = {}
    lanes = np.zeros(len(seeds), np.uint64)
    for i, seed in enumerate(seeds.tolist()):
        lanes[i] = seen.setdefault(seed, 0)
        seen[seed] += 1
    return lanes


def _near_capacity(world: World, params: WorldParams) -> int:
    """Room for the mean and ten standard deviations: a Poisson count above has p < 1e-20."""
    length_m = CELL_M + params.ahead_m + params.behind_m + 2 * params.half_max_m
    width_m = CELL_M + 2 * params.aside_m + 2 * params.half_max_m
    # Edges that are open crowd the obstacles inwards, and whole chunks are never split.
    mean = world.density_per_m2 * length_m * width_m
    return math.ceil(mean + 10 * math.sqrt(mean) + 20)
