"""Braitenberg's vehicles 2a and 2b: each side's light drives a motor.

Source: V. Braitenberg, *Vehicles*, 1984. In 2a a bright side drives the motor of its own side, so
the vehicle turns away from what it sees; in 2b the wires cross, and it turns towards it. At uniform
speed only the difference of the motors counts, so 2a is 3b, and 2b is 3a:

    T = k (mean of I^p cos φ over the right half − the same over the left half)

with k = 1 for 2a and −1 for 2b, which is the negative control: it must do worse than blind.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.rays import bearings_rad, brightness
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = "V. Braitenberg, Vehicles: Experiments in Synthetic Psychology, 1984"


@dataclass(frozen=True)
class Braitenberg2a:
    """Turns away from the brighter side."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "power": Span(0.5, 6.0),
        "dead_band": Span(1e-4, 0.2, is_log=True),
    }

    power: float = 2.0
    """p: how much more bright rays count than dark ones."""
    dead_band: float = 0.01
    """Difference of the two sides below which it stays on its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        return steer(self._turn(brightness(retinas)), self.dead_band)

    def _turn(self, rays: Floats) -> Floats:
        half = rays.shape[1] // 2
        weights = np.cos(bearings_rad(self.contract.retina)).astype(np.float32)
        lit = rays ** np.float32(self.power) * weights
        turn: Floats = lit[:, half:].mean(axis=1) - lit[:, :half].mean(axis=1)
        return turn


@dataclass(frozen=True)
class Braitenberg2b(Braitenberg2a):
    """Turns towards the brighter side: the negative control."""

    SEARCHED: ClassVar[Mapping[str, Span]] = {}

    def _turn(self, rays: Floats) -> Floats:
        return -super()._turn(rays)
