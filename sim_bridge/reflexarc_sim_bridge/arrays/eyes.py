"""The eyes of a contract as arrays: directions of their rays, and what kind of eye they are."""

import math

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.sensing.ray_values import ray_bearing_rad
from reflexarc_sim_bridge.arrays.layout import TILE_RAYS, EyeParams, Floats32
from reflexarc_sim_bridge.arrays.sub_rays import sub_rays
from reflexarc_sim_bridge.worlds.world import World

STEEPEST = np.float32(1e-9)
"""Components of a direction count as no smaller: their reciprocals stay finite."""

_WIDE_RAD = 0.99 * math.pi
"""An eye or a tile that spans more has no two edges between which all of its rays lie."""


def eye_params(contract: PolicyContract, world: World) -> EyeParams:
    """The eyes of a contract in a world, whose scanner and dead sectors they have.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    spec = contract.retina
    bearings, samples = sub_rays(spec, world.scanner)
    blended = 1 if spec.beams is BeamRule.SECTOR_MINIMUM else samples
    # The last tile is filled up with copies of the last ray.
    padding = -len(bearings) % TILE_RAYS
    tile_rad = max(
        bearings[first] - bearings[min(first + TILE_RAYS, len(bearings)) - 1]
        for first in range(0, len(bearings), TILE_RAYS)
    )
    return EyeParams(
        rays=spec.rays,
        samples=samples,
        blended=blended,
        eyes=spec.eyes,
        channels=spec.channels,
        frames=spec.frames,
        half_baseline_m=spec.baseline_m / 2 if spec.eyes == 2 else 0.0,
        range_m=spec.range_m,
        nearness=spec.shading is Shading.NEARNESS,
        is_wide=bearings[0] - bearings[-1] > _WIDE_RAD,
        tile_is_wide=tile_rad > _WIDE_RAD,
        is_plain=(spec.eyes, spec.channels, blended) == (1, 1, 1) and spec.rays % TILE_RAYS == 0,
        turns=turns(contract),
        ahead=np.cos(bearings + bearings[-1:] * padding).astype(np.float32),
        left=np.sin(bearings + bearings[-1:] * padding).astype(np.float32),
        alive=np.array([_is_alive(ray, spec, world) for ray in range(spec.rays)], np.bool_),
    )


def turns(contract: PolicyContract) -> bool:
    """Whether any action turns the agent."""
    return any(action.angular_radps != 0.0 for action in contract.actions)


def seen_behind_m(spec: RetinaSpec, world: World) -> float:
    """How far behind an eye that looks ahead sees: range · (−cos φ) of its outermost bearing φ."""
    bearings = sub_rays(spec, world.scanner).bearings_rad
    outermost_rad = max(abs(bearings[0]), abs(bearings[-1]))
    return spec.range_m * max(0.0, -math.cos(outermost_rad))


def reciprocals(components: Floats32) -> Floats32:
    """1 / component, finite, as `vision.ray_directions.aim` computes it."""
    steepest = np.maximum(np.abs(components), STEEPEST)
    return (1.0 / np.copysign(steepest, components)).astype(np.float32)


def _is_alive(ray: int, spec: RetinaSpec, world: World) -> bool:
    bearing_rad = ray_bearing_rad(ray, spec.rays, spec.fov_rad)
    return not any(low <= bearing_rad <= high for low, high in world.senses.dead_sectors)
