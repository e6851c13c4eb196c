"""From a scan to a retina: one definition for the bus, for replay, and for the simulator's tests.

Nothing is shown as free that was not measured as free: something too near to be measured is as
bright as can be, and so is a ray of which nothing is known. Where too much is unknown, there is no
retina.
"""

import math

import numpy as np

from reflexarc_runtime.arrays import Mask, Ranges, Retina
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError
from reflexarc_runtime.sensing.beam_rules import Looks, looks_along, looks_at
from reflexarc_runtime.sensing.ray_values import FULL_SCALE, ray_bearing_rad
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError, check_sweep

MAX_UNKNOWN_SHARE = 0.25
"""Of all rays, and of those in the middle half of the field of view: the way ahead."""


def check_scannable(spec: RetinaSpec) -> None:
    """Refuse a contract whose retina no single planar scan can give.

    Raises:
        ContractError: more than one eye or channel.
    """
    if spec.eyes != 1 or spec.channels != 1:
        raise ContractError(
            f"a scan gives one eye and one channel, the policy sees {spec.eyes} eyes and "
            f"{spec.channels} channels; give it retinas instead (--input retina)"
        )


def retina_from_scan(scan: Scan, spec: RetinaSpec) -> Retina:
    """Make a retina by the rule of its eye; everything that a scan meets has colour 1.

    `sector_minimum`: a ray shows the nearest return of all beams in its sector. `nearest_beam`: the
    one of the beam nearest to its bearing; where it has several samples, their mean.

    Raises:
        UnusableScanError: the angles cannot be meant, the scan does not cover the field of view,
            or more than a quarter of the rays, or of those ahead, are unknown.
    """
    check_sweep(scan)
    distances_m, known = _distances(scan, spec)
    _check_known(known, scan, spec)
    share = distances_m / spec.range_m
    bright = 1.0 - share if spec.shading is Shading.NEARNESS else np.ones_like(share)
    bright = np.where(share < 1.0, bright, 0.0)
    values = FULL_SCALE * bright.reshape(spec.rays, -1).mean(axis=1) + 0.5
    retina: Retina = values.astype(np.uint8).reshape(spec.shape)
    return retina


def _distances(scan: Scan, spec: RetinaSpec) -> tuple[Ranges, Mask]:
    """Of each look: the distance of its nearest return (0 where none is known), and if any is."""
    ranges_m = scan.ranges_m
    known = (ranges_m > 0.0) | (ranges_m == -math.inf)
    ranges_m = np.maximum(ranges_m, 0.0)
    if scan.is_centred:
        return _nearest(ranges_m, known, looks_at(scan, spec))
    bearings_rad, ranges_m = _from_the_centre(scan, ranges_m, known, spec)
    looks, blind = looks_along(bearings_rad, scan.step_rad, spec)
    distances_m, seen = _nearest(ranges_m, known, looks)
    distances_m[blind], seen[blind] = 0.0, False
    return distances_m, seen


def _nearest(ranges_m: Ranges, known: Mask, looks: Looks) -> tuple[Ranges, Mask]:
    meant_m = np.where(known, ranges_m, math.inf)
    distances_m = np.minimum.reduceat(meant_m[looks.beams], looks.starts)
    seen = np.logical_or.reduceat(known[looks.beams], looks.starts)
    return np.where(seen, distances_m, 0.0), seen


def _from_the_centre(
    scan: Scan, ranges_m: Ranges, known: Mask, spec: RetinaSpec
) -> tuple[Ranges, Ranges]:
    """Bearings and distances of what the beams met, from the point about which the robot turns.

    A beam that met nothing goes as far as the eye does. What is too near to be measured, or
    unknown, stays on its beam, at distance 0.
    """
    beams_rad = scan.start_rad + scan.step_rad * np.arange(len(ranges_m))
    free = known & (ranges_m == math.inf)
    far_m = spec.range_m + math.hypot(scan.x_m, scan.y_m)
    lengths_m = np.where(free, far_m, np.where(known, ranges_m, 0.0))
    x_m = scan.x_m + lengths_m * np.cos(beams_rad)
    y_m = scan.y_m + lengths_m * np.sin(beams_rad)
    met = known & (ranges_m > 0.0)
    distances_m = np.where(met, np.hypot(x_m, y_m), 0.0)
    return np.where(met, np.arctan2(y_m, x_m), beams_rad), np.where(free, math.inf, distances_m)


def _check_known(known: Mask, scan: Scan, spec: RetinaSpec) -> None:
    rays: Mask = np.all(known.reshape(spec.rays, -1), axis=1)
    if rays.all():
        return
    bearings = [ray_bearing_rad(ray, spec.rays, spec.fov_rad) for ray in range(spec.rays)]
    ahead = rays[np.abs(bearings) <= 0.25 * spec.fov_rad]
    for seen, where in ((rays, ""), (ahead, " ahead")):
        unknown = int(np.count_nonzero(~seen))
        if unknown > MAX_UNKNOWN_SHARE * len(seen):
            raise UnusableScanError(
                f"{unknown} of {len(seen)} rays{where} unknown, at most a quarter may be"
                f"{_advice(scan.ranges_m)}"
            )


def _advice(ranges_m: Ranges) -> str:
    """Which flag would give unknown ranges a meaning, if it is what the driver means."""
    nans, zeros = int(np.isnan(ranges_m).sum()), int((ranges_m == 0.0).sum())
    if not nans + zeros:
        return ""
    word, count = ("nan", nans) if nans >= zeros else ("zero", zeros)
    return f"; {count} beams are {word}: if the driver means nothing met by it: --no-return {word}"
