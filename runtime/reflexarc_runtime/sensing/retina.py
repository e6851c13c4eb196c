"""From a scan to a retina: one definition for the bus, for replay, and for the simulator's tests.

Nothing is shown as free that was not measured as free: something too near to be measured is as
bright as can be, and so is a ray of which nothing is known. Where too much is unknown, there is no
retina.
"""

import numpy as np

from reflexarc_runtime.arrays import Mask, Ranges, Retina
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError
from reflexarc_runtime.sensing.beam_rules import returns_seen
from reflexarc_runtime.sensing.from_the_centre import returns_from_centre
from reflexarc_runtime.sensing.ray_values import FULL_SCALE, ray_bearing_rad
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError

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
    nearest_m = returns_seen(scan, spec) if scan.is_centred else returns_from_centre(scan, spec)
    unknown = np.isnan(nearest_m)
    if unknown.any():
        _check_known(~unknown, scan, spec)
    near = 1.0 - nearest_m / spec.range_m
    if spec.shading is Shading.NEARNESS:
        bright = np.maximum(np.fmin(near, 1.0), 0.0)  # what is unknown is as bright as can be
    else:
        bright = np.where(near <= 0.0, 0.0, 1.0)
    if len(bright) > spec.rays:
        bright = bright.reshape(spec.rays, -1).mean(axis=1)
    retina: Retina = (FULL_SCALE * bright + 0.5).astype(np.uint8).reshape(spec.shape)
    return retina


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
