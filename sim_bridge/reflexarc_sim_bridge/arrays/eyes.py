"""The eyes of a contract as arrays: directions of their rays, and what kind of eye they are."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_sim_bridge.arrays.layout import TILE_RAYS, EyeParams, Floats32
from reflexarc_sim_bridge.arrays.true_bearings import ray_bearings_rad, true_bearings
from reflexarc_sim_bridge.worlds.world import Senses, World

STEEPEST = np.float32(1e-9)
"""Components of a direction count as no smaller: their reciprocals stay finite."""

_WIDE_RAD = 0.99 * math.pi
"""An eye or a tile that spans more has no two edges between which all of its rays lie."""


def eye_params(contract: PolicyContract, world: World) -> EyeParams:
    """The eyes of a contract in a world, whose scanner, mounting and dead sectors they have.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    spec = contract.retina
    bearings, samples = true_bearings(spec, world)
    # Permuted rays have no order: the first and the last one of a tile are not its edges.
    is_mixed = world.senses.permuted != 0
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
        is_wide=is_mixed or bearings[0] - bearings[-1] > _WIDE_RAD,
        tile_is_wide=is_mixed or tile_rad > _WIDE_RAD,
        is_plain=(spec.eyes, spec.channels, blended) == (1, 1, 1) and spec.rays % TILE_RAYS == 0,
        turns=turns(contract),
        ahead=np.cos(bearings + bearings[-1:] * padding).astype(np.float32),
        left=np.sin(bearings + bearings[-1:] * padding).astype(np.float32),
        alive=_alive(spec, world.senses),
    )


def turns(contract: PolicyContract) -> bool:
    """Whether any action turns the agent."""
    return any(action.angular_radps != 0.0 for action in contract.actions)


def seen_behind_m(spec: RetinaSpec, world: World) -> float:
    """How far behind an eye that looks ahead sees: range · (−cos φ) of its hindmost bearing φ."""
    hindmost = min(map(math.cos, true_bearings(spec, world).bearings_rad))
    return spec.range_m * max(0.0, -hindmost)


def reciprocals(components: Floats32) -> Floats32:
    """1 / component, finite, as `vision.ray_directions.aim` computes it."""
    steepest = np.maximum(np.abs(components), STEEPEST)
    return (1.0 / np.copysign(steepest, components)).astype(np.float32)


def _alive(spec: RetinaSpec, senses: Senses) -> npt.NDArray[np.bool_]:
    """Whether each ray looks past all dead sectors, which lie where the body is in the way."""
    bearings_rad = np.array(ray_bearings_rad(spec, senses))
    dead = [(low <= bearings_rad) & (bearings_rad <= high) for low, high in senses.dead_sectors]
    alive: npt.NDArray[np.bool_] = ~np.any([np.zeros(spec.rays, np.bool_), *dead], axis=0)
    return alive
