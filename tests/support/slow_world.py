"""What is around an agent and what it sees, from the chunks, and not from what is kept near it."""

import math
from functools import lru_cache

import numpy as np

from reflexarc_runtime.contract.eye import BeamRule
from reflexarc_sim_bridge.simulation.scene import Outline, outlines_of_chunk
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Drift, Motion, Swing
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.slow_geometry import Floats, moved, ray_lengths_m

ANGLE_ERROR_RAD = 2e-5
"""Directions and places are float32: what a ray grazes depends on so much."""
LENGTH_ERROR_M = 1e-5

chunk = lru_cache(maxsize=100_000)(outlines_of_chunk)


def displaced_m(motion: Motion | None, time_s: float) -> tuple[float, float]:
    match motion:
        case Drift(ahead_mps, left_mps):
            return ahead_mps * time_s, left_mps * time_s
        case Swing(ahead_m, left_m, period_s):
            phase = math.sin(math.tau * time_s / period_s)
            return ahead_m * phase, left_m * phase
    return 0.0, 0.0


def world_of(simulation: Simulation, agent: int) -> World:
    return simulation.world.drawn(int(simulation.params.agents.state["seed"][agent]))


def side_m(world: World) -> float:
    """Of a chunk, across the world."""
    if world.edges is Edges.UNBOUNDED:
        return CHUNK_M
    return world.width_m / max(1, round(world.width_m / CHUNK_M))


def outlines_around(simulation: Simulation, agent: int, within_m: float) -> list[Outline]:
    """All that reaches within some metres of an agent, at its time, and more."""
    world, state = world_of(simulation, agent), simulation.params.agents.state[agent]
    x_m, y_m = float(simulation.x_m[agent]), float(simulation.y_m[agent])
    time_s, found = float(state["steps"]) * world.dt_s, []
    for number, layer in enumerate(world.layers):
        ahead_m, left_m = displaced_m(layer.motion, time_s)
        reach_m = within_m + (2 if world.edges is Edges.OPEN else 1) * layer.reach_m
        for i in _between(x_m - ahead_m, reach_m, CHUNK_M):
            for j in _between(y_m - left_m, reach_m, side_m(world)):
                if world.edges is Edges.OPEN and not 0 <= j < round(world.width_m / CHUNK_M):
                    continue
                outlines = chunk(world, int(state["seed"]), i, j)
                found += [moved(o, ahead_m, left_m) for o in outlines if o.layer == number]
    return found


def eye_place_m(simulation: Simulation, agent: int, eye: int) -> Floats:
    """Where an eye is; of two, the left one is eye 0."""
    spec, heading_rad = simulation.contract.retina, float(simulation.heading_rad[agent])
    side = 0.0 if spec.eyes == 1 else spec.baseline_m * (0.5 - eye)
    x_m, y_m = float(simulation.x_m[agent]), float(simulation.y_m[agent])
    return np.array([x_m - side * math.sin(heading_rad), y_m + side * math.cos(heading_rad)])


def directions_rad(simulation: Simulation, agent: int) -> Floats:
    """Of every sub-ray, the leftmost first."""
    spec = simulation.contract.retina
    count = spec.rays * spec.samples
    bearings = spec.fov_rad * (0.5 - (np.arange(count) + 0.5) / count)
    return bearings + float(simulation.heading_rad[agent])


def first_met_m(
    outlines: list[Outline], eye_m: Floats, bearings_rad: Floats
) -> tuple[Floats, Floats]:
    """Least and greatest distance that a ray can mean, its direction being good to so much."""
    nearest = [
        np.min(ray_lengths_m(outlines, eye_m, bearings_rad + off), axis=0, initial=math.inf)
        for off in (-ANGLE_ERROR_RAD, 0.0, ANGLE_ERROR_RAD)
    ]
    return np.min(nearest, axis=0), np.max(nearest, axis=0)


def slow_retina(
    simulation: Simulation, agent: int, eye: int, outlines: list[Outline]
) -> tuple[Floats, Floats]:
    """Least and greatest value that each ray may show: twice (rays, channels), 0 to 255."""
    spec, world = simulation.contract.retina, world_of(simulation, agent)
    eye_m, bearings = eye_place_m(simulation, agent, eye), directions_rad(simulation, agent)
    colours = np.array([outline.colour for outline in outlines]).reshape(-1, 3)
    if spec.channels == 1:
        colours = colours @ np.array([[0.299], [0.587], [0.114]])
    colours = np.vstack([colours, np.full((1, spec.channels), world.senses.background)])
    shown, lengths_m = [], []
    for off in (-ANGLE_ERROR_RAD, 0.0, ANGLE_ERROR_RAD):
        lengths = ray_lengths_m(outlines, eye_m, bearings + off)
        lengths = np.vstack([lengths, np.full(len(bearings), spec.range_m)])
        first_m = lengths.min(axis=0)
        near = 1.0 - first_m / spec.range_m if spec.shading == "nearness" else np.ones(len(first_m))
        near = np.where(first_m < spec.range_m, near, 1.0)[np.newaxis, :, np.newaxis]
        # Of faces that lie in one plane, as those of two walls, either may be seen.
        is_first = (lengths <= first_m + LENGTH_ERROR_M)[..., np.newaxis]
        bright = colours[:, np.newaxis] * near
        lengths_m += [first_m, first_m]
        shown += [
            np.where(is_first, bright, 9.0).min(axis=0),
            np.where(is_first, bright, 0.0).max(axis=0),
        ]
    parts = np.array(shown).reshape(6, spec.rays, spec.samples, spec.channels)
    if spec.beams is BeamRule.SECTOR_MINIMUM:
        met_m = np.array(lengths_m).reshape(6, spec.rays, spec.samples)
        low, high = _of_the_nearest(parts, met_m)
    else:
        low, high = parts.min(axis=0).mean(axis=1), parts.max(axis=0).mean(axis=1)
    return 255.0 * low, 255.0 * high


def _of_the_nearest(parts: Floats, met_m: Floats) -> tuple[Floats, Floats]:
    """Least and greatest brightness of the nearest of each ray's samples: twice (rays, channels).

    What one sample surely meets hides whatever is farther; anything up to there may be the nearest.
    """
    surely_m = met_m.max(axis=0).min(axis=1)[np.newaxis, :, np.newaxis]
    may_be = (met_m <= surely_m + LENGTH_ERROR_M)[..., np.newaxis]
    low = np.where(may_be, parts, 9.0).min(axis=(0, 2))
    return low, np.where(may_be, parts, 0.0).max(axis=(0, 2))


def _between(middle_m: float, reach_m: float, length_m: float) -> range:
    return range(
        math.floor((middle_m - reach_m) / length_m), math.floor((middle_m + reach_m) / length_m) + 1
    )
