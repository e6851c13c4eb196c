"""Rob-Nav, reconstructed: simple routines, each of which hands over to the next when it fails.

Source: none was found; all that is known of it are four sentences of the paper: inspired by the
earthworm, "simple navigation routines were hierarchically organized and linked by failure
defaults. Succeedingly more difficult problems would invoke more sophisticated routines only on
failure of the lower levels", without identification of objects and "therefore sensor-independent".

    test: the front is clear, no ray has  |r sin φ| < R  and  0 ≤ r cos φ < 2 v t
    level 0   straight                  fails as soon as the test does
    level 1   to the clearer side       for at most 2 t
    level 2   to the other side         for at most 4 t
    level 3   to a random side          for at most a random time between 4 t and 8 t; then again

t is the time to get out of the way of something of half-width R: R / w for a body that sidesteps
with w, √(2R / v ω) for one that turns with ω. A level whose time is over while the test is false
fails and calls the next; the test true leads from every level back to 0. No level is ever skipped.

It sees distances only, so whatever measures them, a retina or a scan, moves it to the same bits.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.picking import picked
from reflexarc_baselines.randomness import drawn
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Mask, Memories, QValues, RetinaBatch
from reflexarc_runtime.choice import slots_of
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

DICE, LEVEL, LEFT, SIDE = range(4)
"""Its memory: the dice, the level, the decisions that the level has left, and the side that it
goes to, 1 for the left and −1 for the right."""

_LIMITS = (0.0, 2.0, 4.0, 4.0)
"""For how long a level may last, in t; the last one at least, and at most twice as long."""


@dataclass(frozen=True)
class RobNav:
    """Straight on while the front is clear; then ever longer ways around."""

    ORIGIN: ClassVar[Origin] = Origin(
        "Rob-Nav, as the paper describes it; no source found",
        Fidelity.RECONSTRUCTED,
        Sees.RANGES,
        remarks="test, time limits and the clearer side are ours",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {"half_width_m": Span(0.1, 1.0)}

    half_width_m: float = 0.21
    """R: half the width of an obstacle and the body."""
    period_s: float = 0.1
    """Time between two decisions."""
    drives_by: PolicyContract = field(default_factory=reference_contract)
    """Its eye and its motions."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's, with its memory."""
        return replace(self.drives_by, rate_hz=1.0 / self.period_s, state=StateSpec(4))

    @property
    def aside_s(self) -> float:
        """t: the time to get out of the way."""
        left = self.drives_by.actions[1]
        if left.lateral_mps:
            return self.half_width_m / left.lateral_mps
        return math.sqrt(2.0 * self.half_width_m / (left.linear_mps * left.angular_radps))

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        ranges_m = distances_m(retinas, self.drives_by.retina)
        starts_anew = self.is_clear(ranges_m)[:, np.newaxis] & (np.arange(4) >= LEVEL)
        following = np.where(
            starts_anew, np.float32(0.0), self._default(memories, ranges_m, retinas)
        )
        q_values, winners = steer(following[:, SIDE])
        return q_values, winners, following

    def is_clear(self, ranges_m: Floats) -> Mask:
        """Whether nothing is in front, where the body goes: (n,).

        Args:
            ranges_m: (n, rays).
        """
        eye = self.drives_by.retina
        bearings = bearings_rad(eye)
        ahead_m, aside_m = ranges_m * np.cos(bearings), np.abs(ranges_m * np.sin(bearings))
        reach_m = 2.0 * self.drives_by.actions[0].linear_mps * self.aside_s
        is_met = (ranges_m < eye.range_m) & (ahead_m >= 0.0)
        is_in_the_way = is_met & (aside_m < self.half_width_m) & (ahead_m < reach_m)
        is_clear: Mask = ~np.any(is_in_the_way, axis=1)
        return is_clear

    def _default(self, memories: Memories, ranges_m: Floats, retinas: RetinaBatch) -> Memories:
        """What they remember if the front is not clear."""
        share, dice = drawn(memories[:, DICE], retinas)
        coin, dice = drawn(dice, retinas)
        level = np.minimum(memories[:, LEVEL] + 1.0, 3.0)
        other = np.where(level < 3.0, -memories[:, SIDE], np.where(coin < 0.5, 1.0, -1.0))
        side = np.where(level < 2.0, _clearer(ranges_m), other)
        called = np.stack([dice, level, self._slots(level, share), side], axis=1)
        following = np.where(memories[:, [LEFT]] <= 0.0, called.astype(np.float32), memories)
        one_decision = (np.arange(4) == LEFT).astype(np.float32)
        later: Memories = following - one_decision
        return later

    def _slots(self, level: Floats, share: Floats) -> Floats:
        """Decisions for which a level may last: (n,)."""
        shortest, longest = (
            [slots_of(times * limit * self.aside_s, 1.0 / self.period_s) for limit in _LIMITS]
            for times in (1.0, 2.0)
        )
        row = np.maximum(level, 0.0).astype(np.int64)
        spread = np.where(level < 3.0, 1.0, np.float32(longest[3] - shortest[3] + 1))
        slots: Floats = picked(np.array(shortest, np.float32), row) + np.floor(share * spread)
        return slots.astype(np.float32)


def _clearer(ranges_m: Floats) -> Floats:
    """The side whose distances have the greater mean; of equal ones the left: (n,).

    Equal but for rounding is equal.
    """
    half = ranges_m.shape[1] // 2
    left, right = ranges_m[:, :half].mean(axis=1), ranges_m[:, -half:].mean(axis=1)
    return np.where(right > left + np.float32(1e-5), np.float32(-1.0), np.float32(1.0))
