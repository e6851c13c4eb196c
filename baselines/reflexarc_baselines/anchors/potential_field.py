"""Potential field: what is near pushes away, and a constant pull leads ahead.

Source: O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", IJRR 5(1),
1986. Each ray that meets something nearer than d0 adds the potential U = ½ (1/d − 1/d0)², whose
force points away from what was met:

    F = −dU/dd = (1/d − 1/d0) / d²,   T = −Σ F sin φ,   δ = the pull ahead

Adapted: a body of uniform speed only chooses between three motions, so the lateral force decides
against the pull. What the force has to say against going ahead at all, cos φ, is lost.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_SOURCE = (
    "O. Khatib, Real-time obstacle avoidance for manipulators and mobile robots, "
    "International Journal of Robotics Research 5(1), 1986"
)


@dataclass(frozen=True)
class PotentialField:
    """Is pushed aside by all that is near."""

    ORIGIN: ClassVar[Origin] = Origin(_SOURCE, Fidelity.ADAPTED, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "reach_m": Span(0.5, 5.0),
        "pull": Span(1e-2, 1e2, is_log=True),
    }

    reach_m: float = 4.24
    """d0: what is farther away does not push."""
    pull: float = 0.0178
    """Lateral force (1/m³) below which it stays on its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        eye = self.contract.retina
        sines = np.sin(bearings_rad(eye)).astype(np.float32)
        # A ray's value tells no distance finer than this: nearer things push no harder.
        nearest_m = eye.range_m / FULL_SCALE
        force = self.force(np.maximum(distances_m(retinas, eye), np.float32(nearest_m)))
        return steer(-(force * sines).sum(axis=1), self.pull)

    def force(self, distances_m: Floats) -> Floats:
        """With which something at each distance pushes, per m³."""
        near_m = np.minimum(distances_m, np.float32(self.reach_m))
        pushed: Floats = (1.0 / near_m - np.float32(1.0 / self.reach_m)) / near_m**2
        return pushed
