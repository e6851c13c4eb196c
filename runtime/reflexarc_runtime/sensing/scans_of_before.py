"""From a scan to a retina as it was up to version 3 of the controller's rules.

Kept as it was, so that logs of that time replay: an unknown ray showed nothing, something too near
to be measured (−inf) was unknown, and a sweep could be of any length.
"""

import math

import numpy as np

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.sensing.ray_values import brightness, nearest_beam, ray_bearing_rad, value
from reflexarc_runtime.sensing.scan import MIN_STEP_RAD, Scan, UnusableScanError

_MAX_UNKNOWN_SHARE = 0.25


def retina_of_before(scan: Scan, spec: RetinaSpec) -> Retina:
    """Make a retina: each ray takes the beam nearest to its bearing, with colour 1.

    Where a ray has several samples, each takes its nearest beam, and the ray shows their mean.

    Raises:
        UnusableScanError: the scan does not cover the field of view, or more than a quarter of
            the rays are unknown (NaN, zero or negative).
    """
    distances = [scan.ranges_m[beam] for beam in _beams(scan, spec)]
    unknown = sum(not distance > 0.0 for distance in distances)
    if unknown > _MAX_UNKNOWN_SHARE * len(distances):
        raise UnusableScanError(
            f"{unknown} of {len(distances)} rays unknown, at most a quarter may be"
        )
    nearness = spec.shading is Shading.NEARNESS
    bright = [
        brightness(1.0, float(d) / spec.range_m, nearness) if d > 0.0 else 0.0 for d in distances
    ]
    n = spec.samples
    values = [value(sum(bright[first : first + n]) / n) for first in range(0, len(bright), n)]
    return np.array(values, np.uint8).reshape(spec.shape)


def _beams(scan: Scan, spec: RetinaSpec) -> list[int]:
    count = len(scan.ranges_m)
    if count < 2 or not MIN_STEP_RAD <= scan.step_rad <= math.pi:
        raise UnusableScanError(f"{count} beams from {scan.start_rad} to {scan.end_rad} rad")
    rays = spec.rays * spec.samples
    bearings = (ray_bearing_rad(ray, rays, spec.fov_rad) for ray in range(rays))
    beams = [nearest_beam(bearing, scan.start_rad, scan.step_rad) for bearing in bearings]
    if abs(count * scan.step_rad - 2.0 * math.pi) < 0.5 * scan.step_rad:
        beams = [beam % count for beam in beams]  # a full circle: after the last comes the first
    if max(beams) >= count:
        raise UnusableScanError(
            f"beams from {scan.start_rad:.3f} to {scan.end_rad:.3f} rad do not cover the "
            f"field of view of {spec.fov_rad:.3f} rad"
        )
    return beams
