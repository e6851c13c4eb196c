"""Optic-flow balance: fly where both sides glide past equally fast, as bees do between walls.

Sources: M. V. Srinivasan and others, *Range perception through apparent image speed in freely
flying honeybees*, Visual Neuroscience 6, 1991 (bees centre by angular speed); A. P. Duchon,
L. P. Kaelbling and W. H. Warren, *Ecological robotics*, Adaptive Behavior 6, 1998 (the rule on a
robot); N. Linander and others, 2015 (bumblebees go by the largest flow ahead). Abstracts only were
read: gains, dead band and κ are ours.

    L, R = sum of the outward flow of each side;   Δ = (L − R) / (L + R);   T = −Δ

so the body steps away from the side that glides past faster, which is the nearer one if both walls
stand still. Four ways to get L and R:

    flow-balance            gradient flow (`optic_flow`), looked at after steps ahead only
    flow-balance-always     the same at every step, its own sidesteps too; remembers nothing
    flow-largest            the largest flow of each side within the front, in place of the sum
    flow-correlator         Reichardt's correlators (`correlator`) in place of gradients

Commands to slow down where both sides are near do nothing at uniform speed.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.history.flow import correlator
from reflexarc_baselines.history.flow.looking_on_stay import LooksOnStay
from reflexarc_baselines.history.flow.optic_flow import (
    SILENCE,
    balance,
    flow_contract,
    frames_of,
    gradient_flow,
    outward,
    sides,
)
from reflexarc_baselines.rays import bearings_rad
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Mask, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract

KAPPA = Span(0.001, 1.0, is_log=True)
DEAD_BAND = Span(0.01, 0.8, is_log=True)


def origin(
    source: str,
    remarks: str,
    home_world: str = "bees",
    fidelity: Fidelity = Fidelity.ADAPTED,
) -> Origin:
    """Of a system that sees by flow: at home where surfaces are striped."""
    return Origin(source, fidelity, home_world=home_world, remarks=remarks)


_DUCHON = "Duchon, Kaelbling and Warren, Ecological robotics, Adaptive Behavior 6, 1998"


@dataclass(frozen=True)
class _Balances(LooksOnStay, ABC):
    """Steps away from the faster side, whatever tells how fast it is."""

    def _wish(
        self, retinas: RetinaBatch, may_look: Mask, extra: Memories
    ) -> tuple[Floats, Memories]:
        left, right, extra = self._sides(retinas, extra)
        wish = -balance(left, right, self.silence)
        return np.where(may_look, wish, np.float32(0.0)), extra

    @property
    def silence(self) -> float:
        """What is next to no flow, in its unit."""
        return SILENCE

    @abstractmethod
    def _sides(self, retinas: RetinaBatch, extra: Memories) -> tuple[Floats, Floats, Memories]:
        """Outward flow of the left and of the right, (n,) each, and the rest of the memory."""


@dataclass(frozen=True)
class FlowBalance(_Balances):
    """Balances the sums of gradient flow."""

    ORIGIN: ClassVar[Origin] = origin(_DUCHON, "gradient flow, looked at after steps ahead only")
    SEARCHED: ClassVar[Mapping[str, Span]] = {"kappa": KAPPA, "dead_band": DEAD_BAND}

    kappa: float = 0.0697
    """κ: slopes whose squares are below it count less."""
    dead_band: float = 0.0113

    def _sides(self, retinas: RetinaBatch, extra: Memories) -> tuple[Floats, Floats, Memories]:
        flow = outward(gradient_flow(retinas, self.drives_by.retina, self.period_s, self.kappa))
        left, right = self.summed(flow)
        return left, right, extra

    def summed(self, flow: Floats) -> tuple[Floats, Floats]:
        """What counts of each side, (n,) each, of outward flow (n, rays)."""
        return sides(flow)


@dataclass(frozen=True)
class FlowLargest(FlowBalance):
    """Balances the largest flow of each side ahead."""

    ORIGIN: ClassVar[Origin] = origin(
        "Linander and others, 2015: bumblebees", "abstract only; the front's width is ours"
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "kappa": KAPPA,
        "dead_band": DEAD_BAND,
        "front_rad": Span(0.8, 1.4),
    }

    kappa: float = 0.00793
    dead_band: float = 0.0637
    front_rad: float = 0.817
    """Largest bearing, to either side, that counts as ahead."""

    def summed(self, flow: Floats) -> tuple[Floats, Floats]:
        """The largest flow of the front of each side, (n,) each, of outward flow (n, rays)."""
        bearings = bearings_rad(self.drives_by.retina)
        is_left = (bearings > 0.0) & (bearings <= self.front_rad)
        is_right = (bearings < 0.0) & (bearings >= -self.front_rad)
        left: Floats = np.where(is_left, flow, np.float32(0.0)).max(axis=1)
        right: Floats = np.where(is_right, flow, np.float32(0.0)).max(axis=1)
        return left, right


@dataclass(frozen=True)
class FlowCorrelator(_Balances):
    """Balances what correlators say, which see contrast and grating as well as speed."""

    ORIGIN: ClassVar[Origin] = origin(
        "Franceschini, Pichon and Blanes, From insect vision to robot vision, Phil. Trans. B 337, "
        "1992",
        "abstract only; correlators of neighbouring rays, in place of the robot's timers",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "delay_s": Span(0.02, 0.5, is_log=True),
        "mean_s": Span(0.3, 5.0, is_log=True),
        "dead_band": DEAD_BAND,
    }

    dead_band: float = 0.591
    delay_s: float = 0.113
    """Time constant of the correlators' delay."""
    mean_s: float = 1.04
    """Time constant of each ray's mean, which is subtracted first."""

    @property
    def extra(self) -> int:
        """Two filters of each ray, and whether they have begun."""
        return 1 + 2 * self.drives_by.retina.rays

    @property
    def silence(self) -> float:
        """Of products of brightnesses, which are small."""
        return 1e-5

    def _sides(self, retinas: RetinaBatch, extra: Memories) -> tuple[Floats, Floats, Memories]:
        filters = correlator.Filters.of(self.delay_s, self.mean_s, self.period_s)
        signals, delayed, following = filters.followed(frames_of(retinas)[1], extra)
        half = signals.shape[1] // 2
        motion = correlator.leftward(signals, delayed)
        left: Floats = motion[:, : half - 1].mean(axis=1)
        right: Floats = -motion[:, half:].mean(axis=1)
        return left, right, following


@dataclass(frozen=True)
class FlowBalanceAlways:
    """Balances the sums of gradient flow at every step, with its own sidesteps in them."""

    ORIGIN: ClassVar[Origin] = origin(_DUCHON, "gradient flow; remembers nothing")
    SEARCHED: ClassVar[Mapping[str, Span]] = {"kappa": KAPPA, "dead_band": DEAD_BAND}

    kappa: float = 0.144
    """κ: slopes whose squares are below it count less."""
    dead_band: float = 0.0107
    """Imbalance below which it stays on its way."""
    period_s: float = 0.1
    """Time between two frames."""
    drives_by: PolicyContract = field(default_factory=flow_contract)
    """Its eye and its motions."""

    @property
    def contract(self) -> PolicyContract:
        """Two frames, no memory."""
        return self.drives_by

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        flow = gradient_flow(retinas, self.drives_by.retina, self.period_s, self.kappa)
        return steer(-balance(*sides(outward(flow))), self.dead_band)
