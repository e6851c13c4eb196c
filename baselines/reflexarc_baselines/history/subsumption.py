"""Subsumption: levels of competence, each of which works alone, joined by wires.

Source: R. A. Brooks, *A robust layered control system for a mobile robot*, IEEE J. Robotics and
Automation 2(1), 1986; its constants second-hand.

    level 0   feelforce   F = −Σ û δφ / d²  over the rays (bearing û) that meet something
              runaway     where |F| > θ: the direction of (1, 0) + k F
              collide     halts: nothing at uniform speed, and not built
    level 1   wander      a new heading ψ every 10 s
              avoid       the direction of û(ψ) + k F; it suppresses what runaway sends
    level 2   look        the farthest passage: the ray whose least of itself and its two
                          neighbours is the longest; of equal ones the one nearest to ahead
              plan        sends its bearing where it is far enough: it inhibits wander, and
                          suppresses the heading that avoid hears

               wander ──(I)──(S)── avoid ───┐
    plan ──────────┴──────┘       runaway ──(S)── motors

What arrives at the motors is T; where nothing does, the body goes on as it is.

Faithful: modules, wires, their state, 10 s. Adapted: the sum is an integral over the bearing (δφ is
the angle between two rays), so that gains hold for any number of rays; the body goes ahead all the
time, so runaway turns it away from its way ahead rather than back; wander stays within a sector
ahead; level 2 has no corridor finder and no odometry: it looks at every decision.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.history import wandering
from reflexarc_baselines.history.vectors import Vectors, pointing, pulled
from reflexarc_baselines.history.wires import Inhibitor, Messages, Suppressor
from reflexarc_baselines.picking import picked
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Mask, Memories, QValues, RetinaBatch
from reflexarc_runtime.choice import slots_of
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = (
    "R. A. Brooks, A robust layered control system for a mobile robot, "
    "IEEE J. Robotics and Automation 2(1), 1986"
)
_ORIGIN = Origin(
    _SOURCE, Fidelity.ADAPTED, Sees.RANGES, remarks="no halt; always ahead; no odometry"
)

_WANDER = slice(0, wandering.SIZE)
_OUTPUT = slice(_WANDER.stop, _WANDER.stop + Suppressor.SIZE)
_HEADING = slice(_OUTPUT.stop, _OUTPUT.stop + Suppressor.SIZE)
_BLANK = slice(_HEADING.stop, _HEADING.stop + Inhibitor.SIZE)
"""Where the memory keeps what wander remembers, and the wires' states."""


class Module(StrEnum):
    """The modules whose output can be cut, for tests and ablations."""

    WANDER = "wander"
    AVOID = "avoid"
    PLAN = "plan"


@dataclass(frozen=True)
class _Level0:
    """What every level rests on."""

    threshold: float = 0.082
    """θ: least force (1/m²) at which runaway speaks."""
    gain: float = 1.72
    """k (m²): the force against the way ahead."""
    dead_band_rad: float = 0.112
    """Heading below which the body stays on its way."""
    drives_by: PolicyContract = field(default_factory=reference_contract)
    """Its eye and its motions."""

    def feelforce(self, retinas: RetinaBatch) -> Vectors:
        """F (1/m²); no distance counts as less than one step of the retina's values."""
        eye = self.drives_by.retina
        ranges_m = distances_m(retinas, eye)
        near_m = np.maximum(ranges_m, np.float32(eye.range_m / FULL_SCALE))
        angle_rad = np.float32(eye.fov_rad / eye.rays)
        push = np.where(ranges_m < eye.range_m, angle_rad / near_m**2, np.float32(0.0))
        return pulled(-push, bearings_rad(eye))

    def runaway(self, force: Vectors) -> Messages:
        """Headings away from what is near (rad)."""
        straight = pointing(np.zeros_like(force.left))
        is_sent = force.lengths > self.threshold
        wish = (straight + force.times(self.gain)).headings_rad
        return Messages(np.where(is_sent, wish, np.float32(0.0)), is_sent)

    def _drive(self, line: Messages) -> tuple[QValues, Actions]:
        return steer(line.values, self.dead_band_rad)


_SEARCHED: Mapping[str, Span] = {
    "gain": Span(0.1, 10.0, is_log=True),
    "dead_band_rad": Span(0.01, 0.8, is_log=True),
}


@dataclass(frozen=True)
class Subsumption0(_Level0):
    """Level 0 alone: runs away from what is near."""

    ORIGIN: ClassVar[Origin] = _ORIGIN
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        **_SEARCHED,
        "threshold": Span(0.05, 2.0, is_log=True),
    }

    @property
    def contract(self) -> PolicyContract:
        """The reference field's, without a memory."""
        return self.drives_by

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        return self._drive(self.runaway(self.feelforce(retinas)))


@dataclass(frozen=True)
class _Wandering(_Level0, ABC):
    """Level 1 over level 0; where wander's heading passes on its way to avoid is left open."""

    wander_s: float = 10.0
    """How long a heading is held."""
    widest_rad: float = 0.188
    """Greatest heading that wander takes."""
    time_constant_s: float = 0.2
    """τ of all wires: two decisions at 10 Hz."""
    period_s: float = 0.1
    """Time between two decisions."""
    mute: tuple[Module, ...] = ()
    """Modules whose output is cut."""

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        slots = slots_of(self.wander_s, 1.0 / self.period_s)
        headings, walk = wandering.wandered(memories[:, _WANDER], retinas, self.widest_rad, slots)
        force = self.feelforce(retinas)
        heard, wires = self._heard(retinas, self._sent(Module.WANDER, headings), memories)
        line, output = Suppressor(self.time_constant_s, self.period_s).passed(
            self.runaway(force), self.avoid(heard, force), memories[:, _OUTPUT]
        )
        q_values, winners = self._drive(line)
        actions = self.drives_by.actions
        walk = wandering.turned(walk, winners, actions, self.period_s)
        return q_values, winners, np.hstack([walk, output, *wires]).astype(np.float32)

    def avoid(self, heading: Messages, force: Vectors) -> Messages:
        """Headings that give way to what is near (rad)."""
        wish = (pointing(heading.values) + force.times(self.gain)).headings_rad
        return self._sent(Module.AVOID, wish, heading.is_sent)

    def _sent(self, module: Module, values: Floats, where: Mask | bool = True) -> Messages:
        is_sent = np.full(len(values), module not in self.mute) & where
        return Messages(np.where(is_sent, values, np.float32(0.0)), is_sent)

    @abstractmethod
    def _heard(
        self, retinas: RetinaBatch, wander: Messages, memories: Memories
    ) -> tuple[Messages, tuple[Memories, ...]]:
        """The headings that avoid hears, and what the wires before it remember."""


@dataclass(frozen=True)
class Subsumption1(_Wandering):
    """Levels 0 and 1: wanders, and avoids while it wanders."""

    ORIGIN: ClassVar[Origin] = _ORIGIN
    SEARCHED: ClassVar[Mapping[str, Span]] = {**_SEARCHED, "widest_rad": Span(0.05, 1.5)}

    gain: float = 1.85
    dead_band_rad: float = 0.212

    @property
    def contract(self) -> PolicyContract:
        """The reference field's, with a memory of wander and of one wire."""
        return replace(self.drives_by, rate_hz=1.0 / self.period_s, state=StateSpec(_OUTPUT.stop))

    def _heard(
        self, retinas: RetinaBatch, wander: Messages, memories: Memories
    ) -> tuple[Messages, tuple[Memories, ...]]:
        return wander, ()


@dataclass(frozen=True)
class Subsumption(_Wandering):
    """All three levels: heads for distant free space where it sees some, else wanders."""

    ORIGIN: ClassVar[Origin] = _ORIGIN
    SEARCHED: ClassVar[Mapping[str, Span]] = {**Subsumption1.SEARCHED, "far_m": Span(0.5, 5.0)}

    gain: float = 5.76
    dead_band_rad: float = 0.075
    widest_rad: float = 0.479
    far_m: float = 3.66
    """Least length of a passage for which plan speaks."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's, with a memory of wander and of three wires."""
        return replace(self.drives_by, rate_hz=1.0 / self.period_s, state=StateSpec(_BLANK.stop))

    def plan(self, retinas: RetinaBatch) -> Messages:
        """Bearings of the farthest passages (rad)."""
        eye = self.drives_by.retina
        passage_m = _least_of_three(distances_m(retinas, eye))
        bearings = bearings_rad(eye)
        outwards = np.argsort(np.abs(bearings), kind="stable")
        best_rad = picked(bearings[outwards], passage_m[:, outwards].argmax(axis=1))
        return self._sent(Module.PLAN, best_rad, passage_m.max(axis=1) >= self.far_m)

    def _heard(
        self, retinas: RetinaBatch, wander: Messages, memories: Memories
    ) -> tuple[Messages, tuple[Memories, ...]]:
        plan = self.plan(retinas)
        inhibitor = Inhibitor(self.time_constant_s, self.period_s)
        suppressor = Suppressor(self.time_constant_s, self.period_s)
        line, blank = inhibitor.passed(wander, plan.is_sent, memories[:, _BLANK])
        heard, heading = suppressor.passed(line, plan, memories[:, _HEADING])
        return heard, (heading, blank)


def _least_of_three(ranges_m: Floats) -> Floats:
    """Of each ray and its neighbours; beyond the edge of the field nothing is known: (n, rays)."""
    padded = np.pad(ranges_m, ((0, 0), (1, 1)), constant_values=0.0)
    return np.minimum(np.minimum(padded[:, :-2], padded[:, 2:]), ranges_m)
