"""The eyes of a contract as arrays: directions of their rays, and what kind of eye they are."""

import math

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.sensing.ray_values import nearest_beam, ray_bearing_rad
from reflexarc_sim_bridge.arrays.layout import TILE_RAYS, EyeParams, Floats32
from reflexarc_sim_bridge.worlds.world import Scanner, World

STEEPEST = np.float32(1e-9)
"""Components of a direction count as no smaller: their reciprocals stay finite."""

_WIDE_RAD = 0.99 * math.pi
"""An eye or a tile that spans more has no two edges between which all of its rays lie."""


def eye_params(contract: PolicyContract, world: World) -> EyeParams:
    """The eyes of a contract in a world, whose scanner and dead sectors they have.

    Behind a scanner a ray looks along the beam nearest to its bearing: what the runtime would take
    from the whole sweep, without casting the other beams.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    spec = contract.retina
    bearings = _bearings(spec, spec.rays * spec.samples)
    if world.scanner is not None:
        bearings = [_beam_bearing_rad(bearing, world.scanner) for bearing in bearings]
    # The last tile is filled up with copies of the last ray.
    padding = -len(bearings) % TILE_RAYS
    tile_rad = max(
        bearings[first] - bearings[min(first + TILE_RAYS, len(bearings)) - 1]
        for first in range(0, len(bearings), TILE_RAYS)
    )
    return EyeParams(
        rays=spec.rays,
        samples=spec.samples,
        eyes=spec.eyes,
        channels=spec.channels,
        frames=spec.frames,
        half_baseline_m=spec.baseline_m / 2 if spec.eyes == 2 else 0.0,
        range_m=spec.range_m,
        nearness=spec.shading is Shading.NEARNESS,
        is_wide=bearings[0] - bearings[-1] > _WIDE_RAD,
        tile_is_wide=tile_rad > _WIDE_RAD,
        is_plain=(spec.eyes, spec.channels, spec.samples) == (1, 1, 1)
        and spec.rays % TILE_RAYS == 0,
        turns=turns(contract),
        ahead=np.cos(bearings + bearings[-1:] * padding).astype(np.float32),
        left=np.sin(bearings + bearings[-1:] * padding).astype(np.float32),
        alive=np.array([_is_alive(b, world) for b in _bearings(spec, spec.rays)], np.bool_),
    )


def turns(contract: PolicyContract) -> bool:
    """Whether any action turns the agent."""
    return any(action.angular_radps != 0.0 for action in contract.actions)


def seen_behind_m(spec: RetinaSpec) -> float:
    """How far behind an eye that looks ahead sees: range · (−cos φ) of its outermost bearing φ."""
    outermost_rad = ray_bearing_rad(0, spec.rays * spec.samples, spec.fov_rad)
    return spec.range_m * max(0.0, -math.cos(outermost_rad))


def reciprocals(components: Floats32) -> Floats32:
    """1 / component, finite, as `vision.ray_directions.aim` computes it."""
    steepest = np.maximum(np.abs(components), STEEPEST)
    return (1.0 / np.copysign(steepest, components)).astype(np.float32)


def _bearings(spec: RetinaSpec, rays: int) -> list[float]:
    return [ray_bearing_rad(ray, rays, spec.fov_rad) for ray in range(rays)]


def _beam_bearing_rad(bearing_rad: float, scanner: Scanner) -> float:
    beam = nearest_beam(bearing_rad, scanner.start_rad, scanner.step_rad)
    if beam >= scanner.beams:
        raise WorldError(
            f"world.scanner: a sweep of {scanner.sweep_rad:.3f} rad has no beam at "
            f"{bearing_rad:.3f} rad; expected one that covers the field of view"
        )
    return scanner.start_rad + beam * scanner.step_rad


def _is_alive(bearing_rad: float, world: World) -> bool:
    return not any(low <= bearing_rad <= high for low, high in world.senses.dead_sectors)
