"""Follow the gap: towards the middle of the widest gap, the more so the nearer something is.

Source: V. Sezer, M. Gokasan, "A novel obstacle avoidance algorithm: Follow the Gap Method",
Robotics and Autonomous Systems 60(9), 2012. With a border at distance d₁ and angle φ₁ to the left
of the axis, and one at d₂ and φ₂ to the right, the gap's centre lies to the right of the axis by

    φ_c = acos((d₁ + d₂ cos(φ₁ + φ₂)) / √(d₁² + d₂² + 2 d₁ d₂ cos(φ₁ + φ₂))) − φ₁

and the robot heads for φ = (α/d_min · φ_c + φ_goal) / (α/d_min + 1), here with φ_goal = 0.
φ_c points to the middle between both border points. Angles without a sign, as the source has them,
make it valid only for borders on both sides of the axis; with signs it holds for all gaps, as long
as both are less than half a turn apart, and so we compute it.

Adapted: each ray that meets something is an obstacle, half a sector wide and widened by
asin(R/d) for the body's radius R; where the field of view ends, so does a gap. T = φ, to the left
positive.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from reflexarc_baselines.anchors.gap_follower import GapFollower
from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.rays import bearings_rad

_SOURCE = (
    "V. Sezer, M. Gokasan, A novel obstacle avoidance algorithm: Follow the Gap Method, "
    "Robotics and Autonomous Systems 60(9), 2012"
)


class Gap(NamedTuple):
    """The widest gap of each agent; all (n,). Bearings are left-positive."""

    left_rad: Floats
    """Bearing of its left border."""
    left_m: Floats
    """Distance of the obstacle there."""
    right_rad: Floats
    right_m: Floats

    @property
    def width_rad(self) -> Floats:
        """Its width; 0 or less if there is none."""
        return self.left_rad - self.right_rad


def centre_rad(gap: Gap) -> Floats:
    """Bearing of the middle between the two border points, left positive: (n,)."""
    cosine = np.cos(gap.width_rad)
    d1, d2 = gap.left_m, gap.right_m
    median = np.sqrt(d1**2 + d2**2 + 2.0 * d1 * d2 * cosine)
    ratio = (d1 + d2 * cosine) / np.maximum(median, np.float32(1e-6))
    centre: Floats = gap.left_rad - np.arccos(np.clip(ratio, -1.0, 1.0))
    return centre


def widest_gap(distances_m: Floats, bearings_rad: Floats, half_rad: Floats, seen_m: float) -> Gap:
    """The widest free interval of bearings between obstacles, or between one and the field's end.

    Args:
        distances_m: of what each ray meets: (n, rays).
        bearings_rad: where the rays look: (rays,).
        half_rad: half of the angle that each obstacle closes: (n, rays).
        seen_m: what is farther away is no obstacle; so far away are the field's ends.
    """
    end_rad = np.float32(bearings_rad[0] + (bearings_rad[0] - bearings_rad[1]) / 2)
    is_met, met_m = distances_m < np.float32(seen_m), np.minimum(distances_m, np.float32(seen_m))
    # A ray that met nothing closes nothing: it stands behind all others, at the field's right end.
    starts = np.where(is_met, np.minimum(bearings_rad + half_rad, end_rad), -end_rad)
    ends = np.where(is_met, np.maximum(bearings_rad - half_rad, -end_rad), end_rad)
    order = np.argsort(-starts, axis=1, kind="stable")
    starts, ends, met_m = (np.take_along_axis(row, order, 1) for row in (starts, ends, met_m))
    edge, far = (np.full((len(met_m), 1), value, np.float32) for value in (end_rad, seen_m))
    lefts, lefts_m = np.hstack([edge, ends]), np.hstack([far, met_m])
    return _widest(lefts, lefts_m, np.hstack([starts, -edge]), np.hstack([met_m, far]))


def _widest(lefts: Floats, lefts_m: Floats, rights: Floats, rights_m: Floats) -> Gap:
    """Of gaps in order; a left border counts only if no obstacle before reaches farther right."""
    rightmost = np.minimum.accumulate(lefts, axis=1)
    is_own = lefts == rightmost
    slots = np.maximum.accumulate(np.where(is_own, np.arange(lefts.shape[1]), 0), axis=1)
    best = (rightmost - rights).argmax(axis=1)
    rows = np.arange(len(best))
    at = slots[rows, best]
    return Gap(lefts[rows, at], lefts_m[rows, at], rights[rows, best], rights_m[rows, best])


@dataclass(frozen=True)
class FollowTheGap(GapFollower):
    """Heads for the middle of the widest gap."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "urgency_m": Span(0.1, 30.0, is_log=True),
        "radius_m": Span(0.0, 0.5),
        "seen_m": Span(0.5, 5.0),
        "dead_band_rad": Span(0.02, 0.8),
    }

    urgency_m: float = 0.958
    """α: how much the gap counts against the goal."""
    radius_m: float = 0.00291
    """R, with what the body wants to keep free."""
    seen_m: float = 1.68
    """What is farther away is no obstacle."""
    dead_band_rad: float = 0.349
    """Heading below which it stays on its way."""

    def heading_rad(self, distances_m: Floats) -> Floats:
        """φ, left positive; 0 where there is no gap: (n,)."""
        eye = self.contract.retina
        nearest_m = np.maximum(distances_m.min(axis=1), np.float32(1e-3))
        share = np.minimum(np.float32(self.radius_m) / np.maximum(distances_m, 1e-3), 1.0)
        half_rad = np.arcsin(share) + np.float32(eye.fov_rad / eye.rays / 2)
        gap = widest_gap(distances_m, bearings_rad(eye), half_rad, self.seen_m)
        weight = np.float32(self.urgency_m) / nearest_m
        heading: Floats = weight * centre_rad(gap) / (weight + np.float32(1.0))
        return np.where(gap.width_rad > 0.0, heading, np.float32(0.0))
