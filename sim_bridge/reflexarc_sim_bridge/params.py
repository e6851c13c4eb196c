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
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.retina import nearest_beam, ray_bearing_rad
from reflexarc_sim_bridge.worlds import Discs, Edges, Rectangles, Scanner, World

CELL_M = 2.0
CHUNK_M = 2.5
"""Length of a chunk along x; it spans the whole width of the world."""

# Rows of `Agents.near[agent]`: one obstacle a column.
NEAR_X, NEAR_Y, NEAR_HALF_LENGTH, NEAR_HALF_WIDTH, NEAR_ROUND, NEAR_COLOUR = range(6)
NEAR_ROWS = 6

_STEEPEST = 1e-9
"""Smaller direction components are taken for this: a finite slope, no division by zero."""


class WorldParams(NamedTuple):
    """A world, compiled, and how far its agents see and move. Only numbers: cheap to hand over."""

    dt_s: float
    stream: int
    width_m: float
    periodic: bool
    mean_count: float
    """Mean number of obstacles in a chunk."""
    none_probability: float
    """Probability of an empty chunk, exp(−mean_count)."""
    half_max_m: float
    """No obstacle reaches farther from its centre, along x or y."""
    disc_share: float
    radius_low_m: float
    radius_high_m: float
    width_low_m: float
    width_high_m: float
    length_low_m: float
    length_high_m: float
    colour_low: float
    colour_high: float
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
    """Obstacles near the agent's cell, rows NEAR_*, y beside the agent: (n, 6, capacity)."""
    ray_distance_m: npt.NDArray[np.float32]
    """Of the last look; the range where nothing was met: (n, rays)."""
    ray_colour: npt.NDArray[np.float32]
    """Of the last look; 0 where nothing was met: (n, rays)."""


def world_params(world: World, contract: PolicyContract) -> WorldParams:
    """A world for the agents that a contract describes: it says how far they see and move."""
    step_m, range_m = world.dt_s * _fastest_mps(contract), contract.retina.range_m
    mean_count = world.density_per_m2 * world.width_m * CHUNK_M
    # A kind that the world has not is given share 0 and any size.
    discs = next((s for s in world.shapes if isinstance(s, Discs)), Discs(share=0.0))
    bars = next((s for s in world.shapes if isinstance(s, Rectangles)), Rectangles(share=0.0))
    return WorldParams(
        world.dt_s,
        world.stream,
        world.width_m,
        world.edges is Edges.PERIODIC,
        mean_count,
        math.exp(-mean_count),
        world.longest_m / 2,
        discs.share / (discs.share + bars.share),
        *discs.radius_m,
        *bars.width_m,
        *bars.length_m,
        *world.colour,
        ahead_m=max(range_m, step_m),
        behind_m=max(_behind_m(contract.retina), step_m),
        aside_m=max(range_m, step_m),
    )


def eye_params(spec: RetinaSpec, scanner: Scanner | None = None) -> EyeParams:
    """One eye of a retina specification.

    Behind a scanner a ray looks along the beam nearest to its bearing: what the runtime would take
    from the whole sweep, without casting the other beams.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    bearings = [ray_bearing_rad(ray, spec.rays, spec.fov_rad) for ray in range(spec.rays)]
    if scanner is not None:
        bearings = [_beam_bearing_rad(bearing, scanner) for bearing in bearings]
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
        near=np.zeros((n, NEAR_ROWS, _near_capacity(world, params))),
        ray_distance_m=np.zeros((n, rays), np.float32),
        ray_colour=np.zeros((n, rays), np.float32),
    )


def _beam_bearing_rad(bearing_rad: float, scanner: Scanner) -> float:
    beam = nearest_beam(bearing_rad, scanner.start_rad, scanner.step_rad)
    if beam >= scanner.beams:
        raise WorldError(
            f"world.scanner: a sweep of {scanner.sweep_rad:.3f} rad has no beam at "
            f"{bearing_rad:.3f} rad; expected one that covers the field of view"
        )
    return scanner.start_rad + beam * scanner.step_rad


def _fastest_mps(contract: PolicyContract) -> float:
    return max(max(abs(a.linear_mps), abs(a.lateral_mps)) for a in contract.actions)


def _behind_m(spec: RetinaSpec) -> float:
    """A ray at bearing φ reaches range · (−cos φ) behind; within ±90° none does."""
    outermost_rad = ray_bearing_rad(0, spec.rays, spec.fov_rad)
    return spec.range_m * max(0.0, -math.cos(outermost_rad))


def _reciprocal(component: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    away_from_0 = np.copysign(np.maximum(np.abs(component), _STEEPEST), component)
    return (1.0 / away_from_0).astype(np.float32)


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
    length_m = CELL_M + params.ahead_m + params.behind_m + world.longest_m
    width_m = CELL_M + 2 * params.aside_m + world.longest_m
    # Open edges crowd the obstacles inwards; a narrow period shows each of them several times.
    own_m = min(width_m, world.width_m) if params.periodic else world.width_m
    images = math.ceil(width_m / world.width_m) if params.periodic else 1
    mean = world.density_per_m2 * length_m * own_m
    return images * math.ceil(mean + 10 * math.sqrt(mean) + 20)
