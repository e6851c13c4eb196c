"""What all that follow a gap have in common: eye, motions, and the way from a heading to an action.

They differ in the heading that they take from the distances. T is that heading, to the left
positive (`steering.py`).
"""

from abc import ABC, abstractmethod

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.rays import distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


class GapFollower(ABC):
    """Goes where its heading points to."""

    dead_band_rad: float
    """Heading below which it stays on its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        rays_m = distances_m(retinas, self.contract.retina)
        return steer(self.heading_rad(rays_m), self.dead_band_rad)

    @abstractmethod
    def heading_rad(self, distances_m: Floats) -> Floats:
        """Where it heads, left positive; 0 where there is no gap: (n, rays) → (n,)."""
