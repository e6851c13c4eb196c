"""Motor schemas: each behaviour is a field of vectors, and the body follows their sum.

Source: R. C. Arkin, *Motor schema-based mobile robot navigation*, Int. J. Robotics Research 8(4),
1989; constants and the two sums second-hand, from TeamBots (its `wander` and `v_Avoid_va`).

    move ahead   (1, 0)
    avoid        from each thing at d: 0 beyond E, (E − d)/(E − s) down to s, huge within s
    noise        a random direction, held 5 s
    swirl        as avoid with its own E, but past each thing, at a right angle to it, on the side
                 to which the noise points; only past things within 90° of the noise

Two ways to add up avoid, because a wall is many things and pushes too much:

    sum       the sum of all
    largest   the direction of the sum, with the magnitude of the largest

T is the direction of the sum of all schemas. Adapted: every ray that meets something meets a thing
of its own; move ahead joins TeamBots' wander, because this body always goes ahead; the gains are
searched. TeamBots has E = 1.5 m (swirl 2 m), s = radius + 0.1 m and all gains 1.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import pi
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.history import wandering
from reflexarc_baselines.history.vectors import Vectors, pointing, pulled
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.choice import slots_of
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

HUGE = 1000.0
"""Magnitude within the safe distance: a thousand times that of any other schema."""

_CANCELLED = np.float32(1e-5)
"""Pushes whose sum is a smaller share of them than this cancel out: what is left is rounding."""

_SEARCHED: Mapping[str, Span] = {
    "influence_m": Span(0.5, 5.0),
    "avoid_gain": Span(0.1, 10.0, is_log=True),
    "noise_gain": Span(0.01, 1.0, is_log=True),
    "swirl_gain": Span(0.01, 1.0, is_log=True),
    "dead_band_rad": Span(0.01, 0.8, is_log=True),
}


def _origin(remarks: str) -> Origin:
    source = "R. C. Arkin, Motor schema-based mobile robot navigation, IJRR 8(4), 1989"
    return Origin(source, Fidelity.ADAPTED, Sees.RANGES, remarks=remarks)


@dataclass(frozen=True)
class _MotorSchemas(ABC):
    """The schemas; how avoid is added up is left open."""

    influence_m: float = 1.52
    """E of avoid: what is farther away does not push."""
    safe_m: float = 0.1
    """s: within it the push is huge. The reference body has no radius."""
    swirl_influence_m: float = 2.0
    """E of swirl."""
    avoid_gain: float = 8.86
    noise_gain: float = 0.0211
    swirl_gain: float = 0.366
    dead_band_rad: float = 0.107
    """Direction of the sum below which the body stays on its way."""
    noise_s: float = 5.0
    """How long a direction of the noise is held."""
    period_s: float = 0.1
    """Time between two decisions."""
    drives_by: PolicyContract = field(default_factory=reference_contract)
    """Its eye and its motions."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's, with a memory of the noise."""
        return replace(self.drives_by, rate_hz=1.0 / self.period_s, state=StateSpec(wandering.SIZE))

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        slots = slots_of(self.noise_s, 1.0 / self.period_s)
        noise, following = wandering.wandered(memories, retinas, pi, slots)
        wish = self._wish(distances_m(retinas, self.drives_by.retina), noise)
        q_values, winners = steer(wish.headings_rad, self.dead_band_rad)
        actions = self.drives_by.actions
        return q_values, winners, wandering.turned(following, winners, actions, self.period_s)

    def _wish(self, ranges_m: Floats, noise_rad: Floats) -> Vectors:
        ahead = pointing(np.zeros_like(noise_rad))
        noise = pointing(noise_rad).times(self.noise_gain)
        avoid = self.avoid(ranges_m).times(self.avoid_gain)
        return ahead + noise + avoid + self.swirl(ranges_m, noise_rad).times(self.swirl_gain)

    def avoid(self, ranges_m: Floats) -> Vectors:
        """Away from what is near, by either sum."""
        magnitudes = self._magnitudes(ranges_m, self.influence_m)
        pushed = pulled(-magnitudes, bearings_rad(self.drives_by.retina))
        return self._added_up(magnitudes, pushed)

    def swirl(self, ranges_m: Floats, noise_rad: Floats) -> Vectors:
        """Past what is near, on the side of the noise."""
        bearings = bearings_rad(self.drives_by.retina)
        aside_rad = (noise_rad[:, np.newaxis] - bearings + np.float32(pi)) % (2.0 * pi) - pi
        is_faced = np.abs(aside_rad) < pi / 2.0
        magnitudes = self._magnitudes(ranges_m, self.swirl_influence_m) * is_faced
        past = magnitudes * np.where(aside_rad >= 0.0, np.float32(1.0), np.float32(-1.0))
        return pulled(past, bearings + np.float32(pi / 2.0))

    def _magnitudes(self, ranges_m: Floats, influence_m: float) -> Floats:
        """Of each ray: (n, rays)."""
        fall = (influence_m - ranges_m) / np.float32(influence_m - self.safe_m)
        is_met = ranges_m < self.drives_by.retina.range_m
        magnitudes = np.where(ranges_m <= self.safe_m, np.float32(HUGE), np.maximum(fall, 0.0))
        return np.where(is_met, magnitudes, np.float32(0.0)).astype(np.float32)

    @abstractmethod
    def _added_up(self, magnitudes: Floats, pushed: Vectors) -> Vectors:
        """From the magnitudes of the rays (n, rays), and the sum of their pushes."""


@dataclass(frozen=True)
class MotorSchemasSum(_MotorSchemas):
    """Every ray pushes for itself."""

    ORIGIN: ClassVar[Origin] = _origin("each ray is a thing; the sum of all")
    SEARCHED: ClassVar[Mapping[str, Span]] = _SEARCHED

    def _added_up(self, magnitudes: Floats, pushed: Vectors) -> Vectors:
        return pushed


@dataclass(frozen=True)
class MotorSchemasLargest(_MotorSchemas):
    """All rays say where to, the nearest how much."""

    ORIGIN: ClassVar[Origin] = _origin("each ray is a thing; the largest of all")
    SEARCHED: ClassVar[Mapping[str, Span]] = _SEARCHED

    influence_m: float = 1.56
    avoid_gain: float = 4.9
    noise_gain: float = 0.0233
    swirl_gain: float = 0.0615
    dead_band_rad: float = 0.547

    def _added_up(self, magnitudes: Floats, pushed: Vectors) -> Vectors:
        lengths = pushed.lengths
        has_direction = lengths > _CANCELLED * magnitudes.sum(axis=1)
        shares = magnitudes.max(axis=1) / np.where(has_direction, lengths, np.float32(1.0))
        return pushed.times(np.where(has_direction, shares, np.float32(0.0)))
