"""Where the sub-rays of an eye look: within each ray's sector, or along the beams of a scanner.

Behind a scanner an eye casts only the beams that the runtime would take from the whole sweep, by
the rule of its contract (`reflexarc_runtime.sensing.beam_rules`).
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from reflexarc_runtime.arrays import Ranges
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.sensing.beam_rules import looks_at
from reflexarc_runtime.sensing.ray_values import nearest_beam, ray_bearing_rad
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError
from reflexarc_sim_bridge.worlds.world import Scanner


class SubRays(NamedTuple):
    """Where the sub-rays of an eye look."""

    bearings_rad: tuple[float, ...]
    """Ray by ray, the leftmost first."""
    samples: int
    """How many a ray has."""


@lru_cache(maxsize=64)  # a family of worlds asks once for every world
def sub_rays(spec: RetinaSpec, scanner: Scanner | None) -> SubRays:
    """Where the sub-rays of an eye look, in a world with such a scanner, or without one.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    if scanner is not None and spec.beams is BeamRule.SECTOR_MINIMUM:
        return _beams_of_sectors(spec, scanner)
    count = spec.rays * spec.samples
    bearings = [ray_bearing_rad(k, count, spec.fov_rad) for k in range(count)]
    if scanner is not None:
        bearings = [_beam_bearing_rad(bearing, scanner) for bearing in bearings]
    return SubRays(tuple(bearings), spec.samples)


def _beams_of_sectors(spec: RetinaSpec, scanner: Scanner) -> SubRays:
    """All beams of each sector; those with few repeat their last one, which changes no minimum."""
    end_rad = scanner.start_rad + scanner.sweep_rad
    try:
        looks = looks_at(Scan(scanner.start_rad, end_rad, np.zeros(scanner.beams)), spec)
    except UnusableScanError as error:
        raise WorldError(f"world.scanner: {error}") from None
    bearings_rad: Ranges = scanner.start_rad + scanner.step_rad * looks.beams.astype(np.float64)
    sectors = [
        _leftmost_first(own, ray, spec)
        for ray, own in enumerate(np.split(bearings_rad, looks.starts[1:]))
    ]
    most = max(map(len, sectors))
    bearings = [bearing for own in sectors for bearing in own + own[-1:] * (most - len(own))]
    return SubRays(tuple(bearings), most)


def _leftmost_first(bearings_rad: Ranges, ray: int, spec: RetinaSpec) -> list[float]:
    """Bearings in falling order, each as near to the ray's own as whole turns bring it."""
    centre_rad = ray_bearing_rad(ray, spec.rays, spec.fov_rad)
    turns = np.round((bearings_rad - centre_rad) / math.tau)
    falling: list[float] = np.sort(bearings_rad - math.tau * turns)[::-1].tolist()
    return falling


def _beam_bearing_rad(bearing_rad: float, scanner: Scanner) -> float:
    beam = nearest_beam(bearing_rad, scanner.start_rad, scanner.step_rad)
    if beam >= scanner.beams:
        raise WorldError(
            f"world.scanner: a sweep of {scanner.sweep_rad:.3f} rad has no beam at "
            f"{bearing_rad:.3f} rad; expected one that covers the field of view"
        )
    return scanner.start_rad + beam * scanner.step_rad
