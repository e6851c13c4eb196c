"""From distances to a retina: one definition for simulator, bus and replay.

The functions on single numbers are plain Python. The simulator compiles these same functions and
computes their arguments to the same bits, so that a simulated eye, a real scan and a replayed one
agree.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.arrays import Ranges, Retina
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError

FULL_SCALE = 255
MAX_UNKNOWN_SHARE = 0.25
MIN_STEP_RAD = 1e-9
"""Smallest angle between beams that is accepted; below it, the index of a beam may overflow."""


def ray_bearing_rad(ray: int, rays: int, fov_rad: float) -> float:
    """Bearing of a ray: rays sit at the centres of equal sectors, ray 0 is the leftmost."""
    return fov_rad * (0.5 - (ray + 0.5) / rays)


def brightness(colour: float, share: float, nearness: bool) -> float:
    """Brightness, 0 to 1, of a thing of `colour` (0 to 1) at this share of the range.

    A share of 1 or more, +inf or NaN means that nothing is within range: background, 0.
    """
    if not share < 1.0:
        return 0.0
    return colour * (1.0 - share) if nearness else colour


def value(bright: float) -> int:
    """A brightness from 0 to 1 as an 8-bit value of a retina."""
    return int(FULL_SCALE * bright + 0.5)


def shade(colour: float, distance_m: float, range_m: float, nearness: bool) -> int:
    """Value of a ray that meets something of `colour` (0 to 1) at `distance_m`."""
    return value(brightness(colour, distance_m / range_m, nearness))


def nearest_beam(bearing_rad: float, start_rad: float, step_rad: float) -> int:
    """Index of the beam nearest to a bearing, on the circle; of two equally near the later one."""
    offset_rad = (bearing_rad - start_rad + 0.5 * step_rad) % (2.0 * math.pi)
    return int(offset_rad / step_rad)


def is_unknown(distance_m: float) -> bool:
    """Whether a distance is no measurement: NaN, zero or negative. +inf is one: nothing was met."""
    return not distance_m > 0.0


@dataclass(frozen=True)
class Scan:
    """One sweep of a range sensor. Beams go counter-clockwise from `start_rad` to `end_rad`."""

    start_rad: float
    end_rad: float
    ranges_m: Ranges

    @property
    def step_rad(self) -> float:
        """Angle from one beam to the next."""
        return (self.end_rad - self.start_rad) / (len(self.ranges_m) - 1)


class UnusableScanError(ValueError):
    """A scan from which no retina can be made; its message says why."""


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
    """Make a retina: each ray takes the beam nearest to its bearing, with colour 1.

    Where a ray has several samples, each takes its nearest beam, and the ray shows their mean.

    Raises:
        UnusableScanError: the scan does not cover the field of view, or more than a quarter of
            the rays are unknown (NaN, zero or negative).
    """
    distances = [scan.ranges_m[beam] for beam in _beams(scan, spec)]
    unknown = sum(map(is_unknown, distances))
    if unknown > MAX_UNKNOWN_SHARE * len(distances):
        raise UnusableScanError(
            f"{unknown} of {len(distances)} rays unknown, at most a quarter may be"
        )
    nearness = spec.shading is Shading.NEARNESS
    bright = [
        0.0 if is_unknown(d) else brightness(1.0, float(d) / spec.range_m, nearness)
        for d in distances
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
