"""Which beams of a scan each ray looks along: those of its sector, or the nearest one.

A ray's sector is the part of the field of view of which it is the centre line. A beam on the line
between two sectors belongs to both; a sector without a beam takes the nearest one.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Ranges
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.sensing.ray_values import nearest_beam, ray_bearing_rad
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError

Indices = npt.NDArray[np.int64]

_SLACK = 1e-6
"""Share of a sector by which a beam may miss it and still belong to it: angles are rounded."""


class Looks(NamedTuple):
    """The beams of each look of an eye, one look after the other."""

    beams: Indices
    """Indices into the scan's ranges."""
    starts: Indices
    """Where in `beams` each look begins, (looks,)."""


def looks_of(spec: RetinaSpec) -> int:
    """How many looks an eye takes at a scan: a ray whose rule is a sector looks once."""
    return spec.rays if spec.beams is BeamRule.SECTOR_MINIMUM else spec.rays * spec.samples


def looks_at(scan: Scan, spec: RetinaSpec) -> Looks:
    """The beams that each look of an eye takes from a scan around the robot's centre.

    Raises:
        UnusableScanError: the scan does not cover the field of view.
    """
    return _even_looks(scan.start_rad, scan.end_rad, len(scan.ranges_m), spec)


def looks_along(bearings_rad: Ranges, step_rad: float, spec: RetinaSpec) -> tuple[Looks, Indices]:
    """The same for beams with any bearings, seen from the robot's centre; and the blind looks.

    Args:
        bearings_rad: (beams,).
        step_rad: angle between two beams, as the scanner itself sees it.
        spec: the eye.

    Returns:
        The looks, and the indices of those of them to which no beam is near.
    """
    order = np.argsort(np.mod(bearings_rad, 2.0 * math.pi), kind="stable")
    nearest = order[_nearest_places(np.mod(bearings_rad, 2.0 * math.pi)[order], spec)]
    centres = _centres_rad(spec)
    apart = np.abs(np.mod(bearings_rad[nearest] - centres + math.pi, 2.0 * math.pi) - math.pi)
    half_sector = 0.5 * spec.fov_rad / looks_of(spec)
    blind = np.flatnonzero(apart > max(2.0 * step_rad, half_sector * (1.0 + _SLACK)))
    return _looks(bearings_rad, nearest, spec), blind


@lru_cache(maxsize=16)
def _even_looks(start_rad: float, end_rad: float, count: int, spec: RetinaSpec) -> Looks:
    scan = Scan(start_rad, end_rad, np.zeros(count))
    bearings_rad: Ranges = start_rad + scan.step_rad * np.arange(count, dtype=np.float64)
    return _looks(bearings_rad, _nearest_beams(scan, spec), spec)


def _looks(bearings_rad: Ranges, nearest: Indices, spec: RetinaSpec) -> Looks:
    """Each look with its nearest beam, and with all of its sector where that is the rule."""
    count, looks = len(bearings_rad), looks_of(spec)
    keys = np.arange(looks) * count + nearest
    if spec.beams is BeamRule.SECTOR_MINIMUM:
        rays, beams = _in_sectors(bearings_rad, spec)
        keys = np.unique(np.concatenate([keys, rays * count + beams]))
    return Looks(keys % count, np.searchsorted(keys // count, np.arange(looks)))


def _in_sectors(bearings_rad: Ranges, spec: RetinaSpec) -> tuple[Indices, Indices]:
    """Pairs of a ray and a beam in its sector."""
    wrapped = np.mod(bearings_rad + math.pi, 2.0 * math.pi) - math.pi
    place = (0.5 * spec.fov_rad - wrapped) * (spec.rays / spec.fov_rad)
    rays = np.concatenate([np.floor(place - _SLACK), np.floor(place + _SLACK)]).astype(np.int64)
    beams = np.tile(np.arange(len(bearings_rad)), 2)
    if spec.fov_rad > 2.0 * math.pi * (1.0 - _SLACK / spec.rays):
        return rays % spec.rays, beams  # beyond the last sector lies the first
    within = (rays >= 0) & (rays < spec.rays)
    return rays[within], beams[within]


def _nearest_beams(scan: Scan, spec: RetinaSpec) -> Indices:
    """The beam nearest to the middle of each look.

    Raises:
        UnusableScanError: the scan does not cover the field of view.
    """
    count, step_rad = len(scan.ranges_m), scan.step_rad
    nearest = [nearest_beam(float(b), scan.start_rad, step_rad) for b in _centres_rad(spec)]
    if abs(count * step_rad - 2.0 * math.pi) < 0.5 * step_rad:
        nearest = [beam % count for beam in nearest]  # a full circle: after the last, the first
    if max(nearest) >= count:
        raise UnusableScanError(
            f"beams from {scan.start_rad:.3f} to {scan.end_rad:.3f} rad do not cover the "
            f"field of view of {spec.fov_rad:.3f} rad"
        )
    return np.array(nearest, np.int64)


def _nearest_places(ascending_rad: Ranges, spec: RetinaSpec) -> Indices:
    """Where among ascending angles, on the circle, the one nearest to each look stands."""
    count = len(ascending_rad)
    after = np.searchsorted(ascending_rad, np.mod(_centres_rad(spec), 2.0 * math.pi)) % count
    before = (after - 1) % count
    to_after, to_before = (
        np.abs(np.mod(ascending_rad[i] - _centres_rad(spec) + math.pi, 2 * math.pi) - math.pi)
        for i in (after, before)
    )
    return np.where(to_after <= to_before, after, before)


def _centres_rad(spec: RetinaSpec) -> Ranges:
    looks = looks_of(spec)
    return np.array([ray_bearing_rad(look, looks, spec.fov_rad) for look in range(looks)])
