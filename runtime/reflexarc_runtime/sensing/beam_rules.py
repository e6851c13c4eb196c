"""Which beams of a scan each ray looks along: those of its sector, or the nearest one.

A ray's sector is the part of the field of view of which it is the centre line. A beam on the line
between two sectors belongs to both; a sector without a beam takes the nearest one. Each beam
speaks for half a step to either side.

Of each look the nearest return is told as in a scan: +inf nothing was met, −inf something is too
near to be measured, NaN nothing is known.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Ranges
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.sensing.ray_values import nearest_beam, ray_bearing_rad
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError, check_sweep

Indices = npt.NDArray[np.int64]

SLACK = 1e-6
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


def returns_seen(scan: Scan, spec: RetinaSpec) -> Ranges:
    """The nearest return of each look at a scan around the robot's centre, (looks,).

    Raises:
        UnusableScanError: the angles cannot be meant, or the scan does not cover the field of view.
    """
    beams, starts = _even_looks(scan.start_rad, scan.end_rad, len(scan.ranges_m), spec)
    returns_m = told(scan.ranges_m.take(beams))
    if len(beams) == len(starts):
        return returns_m
    nearest_m: Ranges = np.fmin.reduceat(returns_m, starts)  # NaN only where nothing is known
    unknown = np.isnan(returns_m)
    if not unknown.any():
        return nearest_m
    unknowns = np.add.reduceat(unknown, starts, dtype=np.int64)
    return without_guesses(nearest_m, unknowns, np.diff(starts, append=len(beams)), spec)


def without_guesses(
    nearest_m: Ranges, unknowns: Indices, beams: Indices, spec: RetinaSpec
) -> Ranges:
    """The nearest returns of sectors, where those that show nothing are known by half their beams.

    Args:
        nearest_m: (rays,).
        unknowns: how many beams of each sector are unknown.
        beams: how many it has.
        spec: the eye.
    """
    guessed = (nearest_m >= spec.range_m) & (2 * unknowns > beams)
    known_m: Ranges = np.where(guessed, math.nan, nearest_m)
    return known_m


def looks_at(scan: Scan, spec: RetinaSpec) -> Looks:
    """The beams that each look of an eye takes from a scan around the robot's centre.

    Raises:
        UnusableScanError: see `returns_seen`.
    """
    return _even_looks(scan.start_rad, scan.end_rad, len(scan.ranges_m), spec)


def told(ranges_m: Ranges) -> Ranges:
    """Ranges in which all that is no measurement is NaN."""
    if ranges_m.min() > 0.0:
        return ranges_m
    return np.where((ranges_m > 0.0) | (ranges_m == -math.inf), ranges_m, math.nan)


def in_sectors(bearings_rad: Ranges, spec: RetinaSpec) -> tuple[Indices, Indices]:
    """Pairs of a ray and a beam in its sector.

    Args:
        bearings_rad: (beams,), from where the eye is.
        spec: the eye.
    """
    wrapped = bearings_rad - 2.0 * math.pi * np.round(bearings_rad / (2.0 * math.pi))
    place = (0.5 * spec.fov_rad - wrapped) * (spec.rays / spec.fov_rad)
    rays = np.floor(place - SLACK).astype(np.int64)
    also = np.floor(place + SLACK).astype(np.int64)
    beams = np.arange(len(bearings_rad))
    twice = (also != rays).nonzero()[0]
    if len(twice):
        rays, beams = np.concatenate([rays, also[twice]]), np.concatenate([beams, twice])
    if spec.fov_rad > 2.0 * math.pi * (1.0 - SLACK / spec.rays):
        return rays % spec.rays, beams  # beyond the last sector lies the first
    within = (rays >= 0) & (rays < spec.rays)
    return rays[within], beams[within]


@lru_cache(maxsize=16)
def centres_rad(spec: RetinaSpec) -> Ranges:
    """Bearing of the middle of each look."""
    looks = looks_of(spec)
    return np.array([ray_bearing_rad(look, looks, spec.fov_rad) for look in range(looks)])


@lru_cache(maxsize=32)
def _even_looks(start_rad: float, end_rad: float, count: int, spec: RetinaSpec) -> Looks:
    scan = Scan(start_rad, end_rad, np.zeros(count))
    check_sweep(scan)
    nearest, looks = _nearest_beams(scan, spec), np.arange(looks_of(spec))
    if spec.beams is not BeamRule.SECTOR_MINIMUM:
        return Looks(nearest, looks)
    bearings_rad: Ranges = start_rad + scan.step_rad * np.arange(count, dtype=np.float64)
    rays, beams = in_sectors(bearings_rad, spec)
    bare = (np.bincount(rays, minlength=spec.rays) == 0).nonzero()[0]
    rays, beams = np.concatenate([rays, bare]), np.concatenate([beams, nearest[bare]])
    order = np.argsort(rays.astype(np.int16), kind="stable")  # at most 4096; sorted by radix
    return Looks(beams[order], np.searchsorted(rays[order], looks))


def _nearest_beams(scan: Scan, spec: RetinaSpec) -> Indices:
    """The beam nearest to the middle of each look.

    Raises:
        UnusableScanError: the scan does not cover the field of view.
    """
    count, step_rad = len(scan.ranges_m), scan.step_rad
    nearest = [nearest_beam(float(b), scan.start_rad, step_rad) for b in centres_rad(spec)]
    beyond_rad = count * step_rad - 2.0 * math.pi
    if abs(beyond_rad) < 0.5 * step_rad:
        nearest = [beam % count for beam in nearest]  # a full circle: after the last, the first
    if max(nearest) >= count:
        raise UnusableScanError(
            f"beams from {scan.start_rad:.3f} to {scan.end_rad:.3f} rad do not cover the "
            f"field of view of {spec.fov_rad:.3f} rad"
        )
    beams = np.array(nearest, np.int64)
    if beyond_rad > -0.5 * step_rad and abs(beyond_rad) > SLACK * step_rad:
        return _nearer_at_the_seam(beams, scan, spec)
    return beams


def _nearer_at_the_seam(beams: Indices, scan: Scan, spec: RetinaSpec) -> Indices:
    """Where a turn is no whole number of steps: the nearest beam of both of its ends."""
    centres, last = centres_rad(spec), len(scan.ranges_m) - 1
    ahead_rad = (centres - scan.start_rad) % (2.0 * math.pi)
    turns_rad = np.array([[0.0], [-2.0 * math.pi], [2.0 * math.pi]])
    others = np.clip(np.round((ahead_rad + turns_rad) / scan.step_rad), 0, last).astype(np.int64)
    among = np.concatenate([beams[np.newaxis], others])
    apart = apart_rad(scan.start_rad + scan.step_rad * among, centres)
    apart[0] -= SLACK * scan.step_rad  # of two equally near the same as in a whole turn
    nearest: Indices = among[apart.argmin(axis=0), np.arange(len(beams))]
    return nearest


def apart_rad(one_rad: Ranges, other_rad: Ranges) -> Ranges:
    """Angles between directions, on the circle."""
    difference = one_rad - other_rad
    apart: Ranges = np.abs(difference - 2.0 * math.pi * np.round(difference / (2.0 * math.pi)))
    return apart
