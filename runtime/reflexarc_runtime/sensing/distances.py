"""What senses tell of distances: the beams of a scan, and the rays of a retina as far as they go.

A ray of `nearness` with value v means something of unknown colour at range · (1 − v/255) or nearer:
a dark thing looks as if it were farther away. 0 means nothing within the range.
"""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.beams import Beams, Fan, fan_of
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError
from reflexarc_runtime.sensing.ray_values import FULL_SCALE, ray_bearing_rad
from reflexarc_runtime.sensing.scan import IGNORED_M, Scan
from reflexarc_runtime.sweep import Floats

_NEAR_M = 0.5
"""How far from a scanner the edge of its sector is looked at, as the robot's centre sees it."""


def check_tells_ranges(spec: RetinaSpec) -> None:
    """Refuse a guard on retinas that tell no distance.

    Raises:
        ContractError: why they do not, and what to do.
    """
    why = why_no_ranges(spec)
    if why:
        raise ContractError(
            f"guard: expected retinas that tell distances, got {why}; give it scans "
            "(--input scan), a range sensor beside it (--guard-ranges scan), or --no-guard"
        )


def why_no_ranges(spec: RetinaSpec) -> str:
    """Why retinas tell no distance; empty if they do."""
    if spec.shading is not Shading.NEARNESS:
        return f"{spec.shading.value} shading"
    if spec.eyes != 1:
        return f"{spec.eyes} eyes"
    if spec.channels != 1:
        return f"{spec.channels} channels"
    if spec.samples != 1 and spec.beams is not BeamRule.SECTOR_MINIMUM:
        return f"rays that show the mean of {spec.samples} directions"
    return ""


def beams_of_retina(retina: Retina, spec: RetinaSpec) -> Beams:
    """The farthest that the thing on each ray can be, of one eye: (…, rays).

    Args:
        retina: (…, 1, rays, 1).
        spec: its eye.
    """
    return Beams(fan_of_rays(spec), distances_of_values(spec.range_m)[retina[..., 0, :, 0]])


def beams_of_scan(scan: Scan) -> Beams:
    """The beams as they were measured, seen from the point about which the robot turns.

    Of a scanner that sits elsewhere, something too near to be measured is very near in the
    direction of its beam and in that of the scanner: whatever goes towards it goes towards either.
    """
    fan, ranges_m = fan_of(scan.start_rad, scan.step_rad, len(scan.ranges_m)), scan.ranges_m
    own = ranges_m == IGNORED_M
    if own.any():  # nothing is there but the robot: it is touched by none, and sees nothing
        fan = _blinded(scan.start_rad, scan.step_rad, len(ranges_m), own.tobytes())
        ranges_m = np.where(own, math.inf, ranges_m)
    if scan.is_centred:
        return Beams(fan, ranges_m)
    met = np.isfinite(ranges_m) & (ranges_m > 0.0)
    lengths_m = np.where(met, ranges_m, 0.0)
    x_m, y_m = scan.x_m + lengths_m * fan.cos, scan.y_m + lengths_m * fan.sin
    away_m = np.hypot(x_m, y_m)
    met &= away_m > 0.0
    per_m = 1.0 / np.where(met, away_m, 1.0)
    cos, sin = np.where(met, x_m * per_m, fan.cos), np.where(met, y_m * per_m, fan.sin)
    away_m = np.where(met, away_m, np.where(lengths_m > 0.0, 0.0, ranges_m))
    if (ranges_m == -math.inf).any():
        place_m = math.hypot(scan.x_m, scan.y_m)
        cos, sin = np.append(cos, scan.x_m / place_m), np.append(sin, scan.y_m / place_m)
        away_m = np.append(away_m, -math.inf)
    return Beams(_narrowed(replace(fan, cos=cos, sin=sin), scan), away_m)


@lru_cache(maxsize=8)
def _blinded(start_rad: float, step_rad: float, count: int, own: bytes) -> Fan:
    """A fan that sees nothing in the sectors of its ignored beams."""
    marked = np.frombuffer(own, np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    sectors = [
        (start_rad + (first - 0.5) * step_rad, start_rad + (last - 0.5) * step_rad)
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]
    return replace(fan_of(start_rad, step_rad, count), blind=tuple(sectors))


def _narrowed(fan: Fan, scan: Scan) -> Fan:
    """Without the part of the sector in which only what is far away is seen from the scanner."""
    if fan.left_rad - fan.right_rad >= 2.0 * math.pi:
        return fan
    right_rad, left_rad = (
        math.remainder(_near_edge_rad(edge_rad, scan) - edge_rad, 2.0 * math.pi)
        for edge_rad in (fan.right_rad, fan.left_rad)
    )
    return replace(
        fan,
        right_rad=fan.right_rad + max(right_rad, 0.0),
        left_rad=fan.left_rad + min(left_rad, 0.0),
    )


def _near_edge_rad(edge_rad: float, scan: Scan) -> float:
    y_m = scan.y_m + _NEAR_M * math.sin(edge_rad)
    return math.atan2(y_m, scan.x_m + _NEAR_M * math.cos(edge_rad))


@lru_cache(maxsize=16)
def fan_of_rays(spec: RetinaSpec) -> Fan:
    """The directions of an eye's rays."""
    first_rad = ray_bearing_rad(0, spec.rays, spec.fov_rad)
    return fan_of(first_rad, -spec.fov_rad / spec.rays, spec.rays)


@lru_cache(maxsize=16)
def distances_of_values(range_m: float) -> Floats:
    """Distance for each value of a ray; a value was rounded, so half a step nearer."""
    values = np.arange(FULL_SCALE + 1, dtype=np.float64)
    distances: Floats = range_m * (1.0 - np.minimum(values + 0.5, FULL_SCALE) / FULL_SCALE)
    return distances
