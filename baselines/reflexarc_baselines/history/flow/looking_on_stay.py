"""A visual loop that is closed now and then: what is seen counts only after a step straight ahead.

One's own sidestep is flow, and turning is more so. Between two frames of which the body stayed on
its way there is none of either, so only those are looked at; after any other motion, and at the
start, when the two frames may show different places, the body stays for a step to look again. If a
hold or a guard has the body do something else than it decided, that one look is wrong.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.history.flow.optic_flow import flow_contract
from reflexarc_baselines.steering import STAY, steer
from reflexarc_runtime.arrays import Actions, Mask, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec


@dataclass(frozen=True)
class LooksOnStay(ABC):
    """Decides by what two frames show, if the body stayed on its way between them."""

    dead_band: float = 0.1
    """Wish below which it stays on its way."""
    period_s: float = 0.1
    """Time between two decisions, and between two frames."""
    drives_by: PolicyContract = field(default_factory=flow_contract)
    """Its eye and its motions."""

    @property
    def contract(self) -> PolicyContract:
        """The eye and the motions, with its memory."""
        return replace(self.drives_by, state=StateSpec(1 + self.extra))

    @property
    def extra(self) -> int:
        """Values of its memory beside the one that says whether the last decision was to stay."""
        return 0

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        may_look: Mask = memories[:, 0] > 0.0
        wish, extra = self._wish(retinas, may_look, memories[:, 1:])
        q_values, winners = steer(wish, self.dead_band)
        stayed = (winners == STAY).astype(np.float32)
        return q_values, winners, np.concatenate([stayed[:, np.newaxis], extra], axis=1)

    @abstractmethod
    def _wish(
        self, retinas: RetinaBatch, may_look: Mask, extra: Memories
    ) -> tuple[Floats, Memories]:
        """The wish to step aside, positive to the left (n,), and the rest of the memory.

        Args:
            retinas: what is seen.
            may_look: whether flow is the surroundings' alone: (n,).
            extra: the rest of the memory: (n, extra).
        """
