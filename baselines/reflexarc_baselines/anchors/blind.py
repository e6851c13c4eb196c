"""Blind: never steers. Makes 2ρR contacts a metre, among things of density ρ and half-width R."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from reflexarc_baselines.baseline import Fidelity, Origin, Span
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


@dataclass(frozen=True)
class Blind:
    """Stays on its way, whatever it sees."""

    ORIGIN: ClassVar[Origin] = Origin("none: the lower limit", Fidelity.OURS)
    SEARCHED: ClassVar[Mapping[str, Span]] = {}

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return reference_contract()

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        return BlindPolicy().decide(retinas)
