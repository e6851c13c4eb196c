"""The twelve lines: look along each of the three motions, and take the freest.

No source: what anyone would write first. The free distance f along a motion is what the shortest of
the few rays nearest to its heading measures; staying on the way is worth a preference p.

    q(stay) = f(ahead) + p,   q(left) = f(left),   q(right) = f(right)
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from reflexarc_baselines.baseline import Fidelity, Origin, Sees, Span
from reflexarc_baselines.headings import free_along_m, headings_rad
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import preferring_to_stay
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


@dataclass(frozen=True)
class ThreeMotions:
    """Takes the motion along which it sees farthest."""

    ORIGIN: ClassVar[Origin] = Origin("none: a plain rule", Fidelity.OURS, Sees.RANGES)
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "rays": Span(1, 5, is_whole=True),
        "preference_m": Span(1e-3, 2.0, is_log=True),
    }

    rays: int = 2
    """How many rays are looked along for each motion."""
    preference_m: float = 0.0224
    """How much farther it must see along another motion before it leaves its way."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        eye, headings = self.contract.retina, headings_rad(self.contract)
        free_m = free_along_m(distances_m(retinas, eye), bearings_rad(eye), headings, self.rays)
        return preferring_to_stay(free_m, self.preference_m)
