"""The limits of a cell, each by its name: who finds out what is possible there."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums, sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy

Limit = Callable[[SuiteCell, Suite, PolicyContract], Sums]
"""From a cell, how much of it, and a motion (see `moving_like`) to sums over each of its worlds."""


def blind_sums(cell: SuiteCell, suite: Suite, motion: PolicyContract) -> Sums:
    """What happens to a body that never steers."""
    blind = Contender(BLIND, BlindPolicy(len(motion.actions)), motion)
    return sums_of(drive(blind, cell, suite, Setting.ROBOT))


LIMITS: Mapping[str, Limit] = MappingProxyType({BLIND: blind_sums})
