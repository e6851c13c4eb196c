"""VFH+: a histogram of what stands in which direction, and the cheapest of its openings.

Source: I. Ulrich, J. Borenstein, "VFH+: reliable obstacle avoidance for fast mobile robots", ICRA
1998. Its weights are as we remember them (5, 2, 2); of its constants no text was at hand.

1. Primary histogram. What a ray meets at distance d counts m = c² (a − b d²), with c = 1 and
   a − b S² = 1 at the range S, in all sectors within asin(R/d) of it, for a body of radius R.
2. Binary histogram. A sector of more than τ_high is blocked, of less than τ_low free; between them
   it is what it was: that is remembered.
3. Masked histogram: what the turning circle forbids. A body that steps aside at once has none.
4. Openings. The middle of a narrow one, both sides of a wide one at half its least width s_max, and
   the goal (ahead) if it lies between these. The candidate c of the least cost wins:

       g(c) = μ₁ Δ(c, goal) + μ₂ Δ(c, heading of the last motion) + μ₃ Δ(c, choice before),
       μ₁ > μ₂ + μ₃

Adapted: T = c, left positive. The source halts where nothing is open, which does nothing at uniform
speed; here it heads for the sector that counts least.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.headings import headings_rad
from reflexarc_baselines.picking import picked
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Mask, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = (
    "I. Ulrich, J. Borenstein, VFH+: reliable obstacle avoidance for fast mobile robots, ICRA 1998"
)


def openings(is_blocked: Mask, least: int) -> tuple[Floats, Mask]:
    """Candidates of every free sector's opening: places (n, sectors, 3), and which of them count.

    Of an opening narrower than `least` sectors only its middle; of a wider one the place half of
    that from its left end, the same from its right end, and the row's middle if it lies between.
    """
    first, last = _ends(is_blocked)
    half, ahead = (least - 1) / 2.0, (is_blocked.shape[1] - 1) / 2.0
    is_wide = last - first + 1 >= least
    from_left = np.where(is_wide, first + half, (first + last) / 2.0)
    from_right = np.where(is_wide, last - half, from_left)
    is_between = is_wide & (from_left <= ahead) & (ahead <= from_right)
    places = np.stack([from_left, from_right, np.full_like(from_left, ahead)], axis=2)
    counts = np.stack([~is_blocked, ~is_blocked, ~is_blocked & is_between], axis=2)
    return places.astype(np.float32), counts


def _ends(is_blocked: Mask) -> tuple[Floats, Floats]:
    """First and last sector of the opening in which each free sector lies: (n, sectors) each."""
    sectors = is_blocked.shape[1]
    places = np.arange(sectors)
    before = np.maximum.accumulate(np.where(is_blocked, places, -1), axis=1)
    behind = np.where(is_blocked, places, sectors)[:, ::-1]
    after = np.minimum.accumulate(behind, axis=1)[:, ::-1]
    return (before + 1).astype(np.float32), (after - 1).astype(np.float32)


@dataclass(frozen=True)
class VfhPlus:
    """Heads for the cheapest opening of a histogram that it remembers."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "radius_m": Span(0.02, 0.5),
        "low": Span(1.0, 60.0, is_log=True),
        "rise": Span(0.0, 1.0),
        "least_sectors": Span(1, 12, is_whole=True),
        "dead_band_rad": Span(0.02, 0.8),
    }

    sectors: int = 36
    """Of the field of view: 5° each over half a turn."""
    radius_m: float = 0.143
    """R, with what the body wants to keep free: half the width that has to be open."""
    falloff_per_m2: float = 1.0
    """b: how much less what is far away counts."""
    low: float = 1.35
    """τ_low: below it a sector is free."""
    rise: float = 0.258
    """τ_high = τ_low (1 + rise): above it a sector is blocked."""
    least_sectors: int = 3
    """s_max: an opening of so many sectors is wide."""
    weights: tuple[float, float, float] = (5.0, 2.0, 2.0)
    """μ₁, μ₂, μ₃: of the goal, the last motion and the choice before."""
    dead_band_rad: float = 0.12
    """Bearing below which it stays on its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions; remembers blocked sectors, motion and choice."""
        return replace(reference_contract(), state=StateSpec(self.sectors + 2))

    @property
    def sectors_rad(self) -> Floats:
        """Bearings of the sectors, the leftmost first."""
        fov_rad = self.contract.retina.fov_rad
        places = (np.arange(self.sectors) + 0.5) / self.sectors
        return (fov_rad * (0.5 - places)).astype(np.float32)

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        was_blocked, motion_rad = memories[:, :-2] > 0.5, memories[:, -2]
        density = self.density(distances_m(retinas, self.contract.retina))
        is_blocked = self.blocked(density, was_blocked)
        choice_rad = self.choice_rad(is_blocked, density, motion_rad, memories[:, -1])
        q_values, actions = steer(choice_rad, self.dead_band_rad)
        done_rad = picked(np.array(headings_rad(self.contract), np.float32), actions)
        columns = [is_blocked, done_rad[:, np.newaxis], choice_rad[:, np.newaxis]]
        return q_values, actions, np.hstack(columns).astype(np.float32)

    def density(self, distances_m: Floats) -> Floats:
        """The primary histogram: (n, sectors)."""
        eye = self.contract.retina
        range_m, b = np.float32(eye.range_m), np.float32(self.falloff_per_m2)
        counts = np.where(distances_m < range_m, 1.0 + b * (range_m**2 - distances_m**2), 0.0)
        share = np.minimum(np.float32(self.radius_m) / np.maximum(distances_m, 1e-3), 1.0)
        off_rad = np.abs(self.sectors_rad[:, np.newaxis] - bearings_rad(eye))
        is_within = off_rad <= np.arcsin(share)[:, np.newaxis, :]
        summed: Floats = np.where(is_within, counts[:, np.newaxis, :], 0.0).sum(axis=2)
        return summed.astype(np.float32)

    def blocked(self, density: Floats, was_blocked: Mask) -> Mask:
        """The binary histogram: (n, sectors)."""
        is_above = density > self.low * (1.0 + self.rise)
        blocked: Mask = is_above | (was_blocked & (density >= self.low))
        return blocked

    def choice_rad(
        self, is_blocked: Mask, density: Floats, motion_rad: Floats, before_rad: Floats
    ) -> Floats:
        """Bearing of the cheapest candidate; where all is blocked, of the least dense sector."""
        places, counts = openings(is_blocked, self.least_sectors)
        bearings = self._bearing_rad(places).reshape(len(places), -1)
        costs = self.cost(bearings, motion_rad, before_rad)
        best = np.where(counts.reshape(costs.shape), costs, np.inf).argmin(axis=1)
        cheapest = np.take_along_axis(bearings, best[:, np.newaxis], 1)[:, 0]
        least_dense = picked(self.sectors_rad, density.argmin(axis=1))
        return np.where(is_blocked.all(axis=1), least_dense, cheapest)

    def _bearing_rad(self, places: Floats) -> Floats:
        middle = np.float32((self.sectors - 1) / 2.0)
        return (middle - places) * np.float32(self.contract.retina.fov_rad / self.sectors)

    def cost(self, candidates: Floats, motion_rad: Floats, before_rad: Floats) -> Floats:
        """G of each candidate: (n, candidates)."""
        of_goal, of_motion, of_choice = map(np.float32, self.weights)
        from_motion = np.abs(candidates - motion_rad[:, np.newaxis])
        from_choice = np.abs(candidates - before_rad[:, np.newaxis])
        total: Floats = (
            of_goal * np.abs(candidates) + of_motion * from_motion + of_choice * from_choice
        )
        return total
