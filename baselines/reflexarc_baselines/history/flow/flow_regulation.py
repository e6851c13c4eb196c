"""Flow regulation: follow a wall at the distance at which it glides past at a set rate.

Sources: N. Franceschini, J. M. Pichon and C. Blanes, *From insect vision to robot vision*, Phil.
Trans. B 337, 1992, whose abstract was read; J. Santos-Victor and others, *Divergent stereo in
autonomous navigation*, Int. J. Computer Vision 14, 1995 (centring and wall following by flow),
which was not. The rule is rebuilt from what is said of both.

The mean outward flow of a half of the field, of 90°, beside a wall at d is v / 2d. The side with
more of it is followed, F its mean flow over some looks and F₀ = v / 2d₀ what it shall be:

    T = ± (F₀ − F) / F₀,   + on the left

so the body steps away from a wall that glides past too fast, and nearer if too slowly. The distance
that it keeps scales with its speed relative to the wall: a wall that moves along at half of the
body's speed is followed at half of the distance. κ makes flow smaller than it is, and d smaller
than d₀ alike.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Span
from reflexarc_baselines.history.flow.flow_balance import DEAD_BAND, KAPPA, origin
from reflexarc_baselines.history.flow.looking_on_stay import LooksOnStay
from reflexarc_baselines.history.flow.optic_flow import gradient_flow, outward, sides
from reflexarc_runtime.arrays import Mask, Memories, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec


@dataclass(frozen=True)
class FlowRegulation(LooksOnStay):
    """Keeps the flow of the nearer side at a set rate."""

    ORIGIN: ClassVar[Origin] = origin(
        "Santos-Victor and others, Int. J. Computer Vision 14, 1995; Franceschini and others, 1992",
        "gradient flow, looked at after steps ahead only; the faster side is followed",
        fidelity=Fidelity.RECONSTRUCTED,
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "kappa": KAPPA,
        "dead_band": DEAD_BAND,
        "wall_m": Span(0.5, 2.0),
        "smooth_s": Span(0.1, 3.0, is_log=True),
    }

    kappa: float = 0.0091
    """κ: slopes whose squares are below it count less."""
    dead_band: float = 0.0227
    wall_m: float = 1.51
    """d₀: distance to keep from the wall that is followed."""
    smooth_s: float = 0.194
    """Time constant of the mean flow of each side, in looks of `period_s` each: one look alone may
    be wrong by as much as it measures."""

    @property
    def contract(self) -> PolicyContract:
        """It begins as if both sides glided past as they shall."""
        begin = float(np.float32(self.set_radps))
        return replace(self.drives_by, state=StateSpec(3, (0.0, begin, begin)))

    @property
    def set_radps(self) -> float:
        """F₀."""
        return self.drives_by.actions[0].linear_mps / (2.0 * self.wall_m)

    def _wish(
        self, retinas: RetinaBatch, may_look: Mask, extra: Memories
    ) -> tuple[Floats, Memories]:
        flow = gradient_flow(retinas, self.drives_by.retina, self.period_s, self.kappa)
        seen = np.stack(sides(outward(flow)), axis=1)
        share = np.float32(1.0 - math.exp(-self.period_s / self.smooth_s))
        means = np.where(may_look[:, np.newaxis], extra + share * (seen - extra), extra)
        side = np.where(means[:, 0] >= means[:, 1], np.float32(1.0), np.float32(-1.0))
        missing = 1.0 - means.max(axis=1) / np.float32(self.set_radps)
        return np.where(may_look, side * missing, 0.0).astype(np.float32), means
