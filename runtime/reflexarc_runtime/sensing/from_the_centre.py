"""What an eye sees from the point about which the robot turns, by a scanner that sits elsewhere.

Each return is a point: it lies in the sector in which the robot's centre sees it. A beam that met
nothing goes as far as the eye does. What is unknown stays on its own bearing. What is too near to
be measured lies somewhere on its beam, near the scanner: it is in every sector that the beam
crosses. A look to which no beam is near is blind.
"""

import math

import numpy as np

from reflexarc_runtime.arrays import Mask, Ranges
from reflexarc_runtime.beams import fan_of
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.sensing.beam_rules import (
    SLACK,
    Indices,
    apart_rad,
    centres_rad,
    in_sectors,
    looks_of,
    told,
    without_guesses,
)
from reflexarc_runtime.sensing.scan import Scan, check_sweep

_BLIND_STEPS = 2.0
"""Beams spread as they are seen from elsewhere: within so many steps one is near enough."""


def returns_from_centre(scan: Scan, spec: RetinaSpec) -> Ranges:
    """The nearest return of each look: +inf none, −inf too near to be measured, NaN unknown.

    Raises:
        UnusableScanError: the angles cannot be meant.
    """
    check_sweep(scan)
    returns_m = told(scan.ranges_m)
    bearings_rad, away_m = _seen(scan, returns_m, spec)
    if spec.beams is BeamRule.SECTOR_MINIMUM:
        rays, beams = in_sectors(bearings_rad, spec)
        nearest_m = np.full(spec.rays, math.nan)
        np.fmin.at(nearest_m, rays, away_m[beams])
        counts = np.bincount(rays, minlength=spec.rays)
        unknowns = np.bincount(rays, np.isnan(away_m[beams]), spec.rays)
        nearest_m = without_guesses(nearest_m, unknowns.astype(np.int64), counts, spec)
        bare = (counts == 0).nonzero()[0]
    else:
        nearest_m = np.empty(looks_of(spec))
        bare = np.arange(len(nearest_m))
    if len(bare):
        centres = centres_rad(spec)[bare]
        nearest_m[bare] = _nearest_m(bearings_rad, away_m, centres, _blind_from_rad(scan, spec))
    near = (returns_m == -math.inf).nonzero()[0]
    if len(near):
        nearest_m[_crossed(scan, near, spec)] = -math.inf
    return nearest_m


def _seen(scan: Scan, returns_m: Ranges, spec: RetinaSpec) -> tuple[Ranges, Ranges]:
    """Bearing, −π to π, and distance of the end of each beam, from the centre."""
    fan = fan_of(scan.start_rad, scan.step_rad, len(returns_m))
    met = returns_m > 0.0
    far_m = spec.range_m + math.hypot(scan.x_m, scan.y_m)
    lengths_m = np.minimum(returns_m, far_m)
    with np.errstate(invalid="ignore"):  # what is too near or unknown has no place
        x_m, y_m = scan.x_m + lengths_m * fan.cos, scan.y_m + lengths_m * fan.sin
        bearings_rad, away_m = np.arctan2(y_m, x_m), np.hypot(x_m, y_m)
    away_m[returns_m >= far_m] = math.inf  # rounded, it might be within the eye's range
    if met.all():
        return bearings_rad, away_m
    own_rad = np.arctan2(fan.sin, fan.cos)
    return np.where(met, bearings_rad, own_rad), np.where(met, away_m, returns_m)


def _blind_from_rad(scan: Scan, spec: RetinaSpec) -> float:
    half_sector_rad = 0.5 * spec.fov_rad / looks_of(spec)
    return max(_BLIND_STEPS * scan.step_rad, half_sector_rad * (1.0 + SLACK))


def _nearest_m(
    bearings_rad: Ranges, away_m: Ranges, centres: Ranges, blind_from_rad: float
) -> Ranges:
    """What the beam tells that is nearest to each centre; NaN where none is near."""
    order = np.argsort(bearings_rad, kind="stable")
    ascending_rad = bearings_rad[order]
    after = np.searchsorted(ascending_rad, centres) % len(order)
    pair = np.stack([after, after - 1])
    apart = apart_rad(ascending_rad[pair], centres)
    columns = np.arange(len(centres))
    nearer = apart.argmin(axis=0)
    told_m = away_m[order[pair[nearer, columns]]]
    return np.where(apart[nearer, columns] > blind_from_rad, math.nan, told_m)


def _crossed(scan: Scan, near: Indices, spec: RetinaSpec) -> Mask:
    """Which looks the given beams cross, on their way from the scanner to far away."""
    turn_rad, place_rad = 2.0 * math.pi, math.atan2(scan.y_m, scan.x_m)
    sweep_rad = scan.start_rad + scan.step_rad * near - place_rad
    sweep_rad -= turn_rad * np.round(sweep_rad / turn_rad)
    half_rad = 0.5 * spec.fov_rad / looks_of(spec) * (1.0 + SLACK)
    ahead_rad = (centres_rad(spec)[:, np.newaxis] - place_rad) * np.copysign(1.0, sweep_rad)
    within = (ahead_rad + half_rad) % turn_rad <= np.abs(sweep_rad) + 2.0 * half_rad
    crossed: Mask = within.any(axis=1)
    return crossed
