"""Where the rays of a retina really look: as its contract says, or as the body was put together.

A world may permute the rays of a retina and turn the eye on the body. The contract, and with it the
policy, goes on to say that ray 0 is the leftmost one and that the middle looks ahead. Both eyes of
a body with two are permuted alike, and turned on the spot where they stand.
"""

import hashlib
from itertools import chain

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.sensing.ray_values import ray_bearing_rad
from reflexarc_sim_bridge.arrays.sub_rays import SubRays, sub_rays
from reflexarc_sim_bridge.worlds.world import Senses, World

_SALT = "reflexarc permuted rays 1"
"""Any change to what a seed draws takes a new number."""


def ray_order(rays: int, seed: int) -> tuple[int, ...]:
    """Which ray of the eye stands at each place of its retina.

    Args:
        rays: of one eye.
        seed: of the permutation, the same in all ages and versions; 0: every ray at its own place.
    """
    if seed == 0:
        return tuple(range(rays))
    return tuple(sorted(range(rays), key=lambda ray: _drawn(seed, ray)))


def true_bearings(spec: RetinaSpec, world: World) -> SubRays:
    """Where the sub-rays look, in the order of the retina: bearings on the body.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    said, senses = sub_rays(spec, world.scanner), world.senses
    if not (senses.permuted or senses.mounted_rad):
        return said
    count = said.samples
    own = [said.bearings_rad[ray * count : (ray + 1) * count] for ray in range(spec.rays)]
    placed = chain.from_iterable(own[ray] for ray in ray_order(spec.rays, senses.permuted))
    return SubRays(tuple(bearing + senses.mounted_rad for bearing in placed), count)


def ray_bearings_rad(spec: RetinaSpec, senses: Senses) -> list[float]:
    """Where the middle of each ray looks, in the order of the retina."""
    order = ray_order(spec.rays, senses.permuted)
    return [ray_bearing_rad(ray, spec.rays, spec.fov_rad) + senses.mounted_rad for ray in order]


def _drawn(seed: int, ray: int) -> bytes:
    return hashlib.sha256(f"{_SALT}:{seed}:{ray}".encode()).digest()
