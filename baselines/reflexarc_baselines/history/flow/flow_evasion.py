"""Evasion by flow: straight on, until what is ahead swells; then aside for a while.

Sources: A. P. Duchon, L. P. Kaelbling and W. H. Warren, *Ecological robotics*, Adaptive Behavior 6,
1998 (balance, with an emergency turn when time to contact is short); J.-C. Zufferey and
D. Floreano, *Fly-inspired visual steering of an ultralight indoor aircraft*, IEEE Trans. Robotics
22, 2006 (quick turns on a threshold). Of the first the abstract was read, of the second nothing but
what others say of it; thresholds and durations are ours.

    flow-emergency     flow balance; if τ of a dark or bright run ahead is below T: aside, away
                       from its middle
    flow-divergence    if D = Σ F φ / Σ φ² of the rays ahead is above a limit: aside, away from the
                       side with more outward flow; else straight on

D is 1/τ of a flat face straight ahead: there F = (v/Z) sin φ cos φ. Once begun, an evasion goes on
for its time without a look.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.history.flow.flow_balance import DEAD_BAND, KAPPA, origin
from reflexarc_baselines.history.flow.looking_on_stay import LooksOnStay
from reflexarc_baselines.history.flow.looming import looming
from reflexarc_baselines.history.flow.optic_flow import balance, gradient_flow, outward, sides
from reflexarc_baselines.rays import bearings_rad
from reflexarc_runtime.arrays import Mask, Memories, RetinaBatch
from reflexarc_runtime.choice import slots_of

URGENT = 2.0
"""Wish of an evasion: above that of any balance, and above any dead band."""


@dataclass(frozen=True)
class _Evades(LooksOnStay, ABC):
    """Keeps to an evasion for its time: remembered as decisions left, negative to the right."""

    evade_s: float = 0.8
    """How long an evasion lasts."""
    kappa: float = 0.05
    """κ: slopes whose squares are below it count less."""
    front_rad: float = 0.6
    """How far to either side counts as ahead."""

    @property
    def extra(self) -> int:
        """The decisions left."""
        return 1

    def _wish(
        self, retinas: RetinaBatch, may_look: Mask, extra: Memories
    ) -> tuple[Floats, Memories]:
        flow = gradient_flow(retinas, self.drives_by.retina, self.period_s, self.kappa)
        calm, alarm = self._calm_and_alarm(retinas, flow)
        fresh = alarm * np.float32(slots_of(self.evade_s, 1.0 / self.period_s))
        left = np.where(extra[:, 0] == 0.0, np.where(may_look, fresh, 0.0), extra[:, 0])
        calm = np.where(may_look, calm, 0.0)
        wish = np.where(left == 0.0, calm, np.float32(URGENT) * np.sign(left))
        following = (left - np.sign(left)).astype(np.float32)
        return wish.astype(np.float32), following[:, np.newaxis]

    @abstractmethod
    def _calm_and_alarm(self, retinas: RetinaBatch, flow: Floats) -> tuple[Floats, Floats]:
        """The wish without need; and 1, −1, 0: evade to the left, to the right, not: (n,) each."""


@dataclass(frozen=True)
class FlowEmergency(_Evades):
    """Balances flow, and evades what will be met soon."""

    ORIGIN: ClassVar[Origin] = origin(
        "Duchon, Kaelbling and Warren, Ecological robotics, Adaptive Behavior 6, 1998",
        "τ by the flat face's sin α / α̇; steps aside in place of turns",
        home_world="bees-posts",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "kappa": KAPPA,
        "dead_band": DEAD_BAND,
        "evade_s": Span(0.1, 3.0, is_log=True),
        "front_rad": Span(0.1, 1.2),
        "urgent_s": Span(0.2, 5.0, is_log=True),
    }

    kappa: float = 0.469
    dead_band: float = 0.0271
    evade_s: float = 0.833
    front_rad: float = 0.192
    urgent_s: float = 2.92
    """T: a time to contact below it is an emergency."""

    def _calm_and_alarm(self, retinas: RetinaBatch, flow: Floats) -> tuple[Floats, Floats]:
        calm = -balance(*sides(outward(flow)))
        run = looming(retinas, self.drives_by.retina, self.front_rad, self.period_s)
        # Straight ahead of its middle the balance decides, and of two equal sides the left.
        aside = np.where(np.abs(run.bearing_rad) > 1e-3, -run.bearing_rad, calm)
        side = np.where(aside >= 0.0, np.float32(1.0), np.float32(-1.0))
        return calm, np.where(run.tau_s < self.urgent_s, side, np.float32(0.0))


@dataclass(frozen=True)
class FlowDivergence(_Evades):
    """Evades where flow diverges, and else goes straight on."""

    ORIGIN: ClassVar[Origin] = origin(
        "Zufferey and Floreano, Fly-inspired visual steering of an ultralight indoor aircraft, "
        "IEEE Trans. Robotics 22, 2006",
        "not read; divergence of the rays ahead; steps aside in place of turns",
        fidelity=Fidelity.RECONSTRUCTED,
        home_world="bees-posts",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "kappa": KAPPA,
        "evade_s": Span(0.1, 3.0, is_log=True),
        "front_rad": Span(0.3, 1.5),
        "limit_radps": Span(0.05, 3.0, is_log=True),
    }

    kappa: float = 0.105
    evade_s: float = 0.295
    front_rad: float = 1.15
    limit_radps: float = 0.329
    """Divergence above which it evades."""

    def divergence_radps(self, flow: Floats) -> Floats:
        """D of the rays ahead: (n,).

        Args:
            flow: of each ray, counter-clockwise: (n, rays).
        """
        bearings = bearings_rad(self.drives_by.retina)
        ahead = np.where(np.abs(bearings) <= self.front_rad, bearings, np.float32(0.0))
        # No dot product: its bits would depend on how many agents there are.
        divergence: Floats = (flow * ahead).sum(axis=1) / np.maximum((ahead**2).sum(), 1e-6)
        return divergence

    def _calm_and_alarm(self, retinas: RetinaBatch, flow: Floats) -> tuple[Floats, Floats]:
        left, right = sides(outward(flow))
        side = np.where(left > right, np.float32(-1.0), np.float32(1.0))
        is_near = self.divergence_radps(flow) > self.limit_radps
        return np.zeros_like(side), np.where(is_near, side, np.float32(0.0))
