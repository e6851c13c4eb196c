"""The limits of a cell, each by its name: who finds out what is possible there.

A limit that nobody knows, such as an oracle for a body of two speeds ahead, has no sums.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.limits.oracle import oracle_sums
from reflexarc_sim_bridge.evaluation.limits.turners import most_reached_m
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums, sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy

ORACLE = "oracle"

Limit = Callable[[SuiteCell, Suite, PolicyContract], Sums]
"""From a cell, how much of it, and a motion (see `moving_like`) to sums over each of its worlds."""


def blind_sums(cell: SuiteCell, suite: Suite, motion: PolicyContract) -> Sums:
    """What happens to a body that never steers."""
    return sums_of(drive(_body_of(motion), cell, suite, Setting.ROBOT))


def best_sums(cell: SuiteCell, suite: Suite, motion: PolicyContract) -> Sums:
    """What happens to one that knows everything; of a body that turns, what nobody beats."""
    body = _body_of(motion)
    if body.turns:
        each_m = most_reached_m(motion, suite.turner_s)
        agents = np.full(suite.worlds, float(suite.lanes))
        return {"agents": agents, "farthest_m": each_m * agents}
    try:
        return oracle_sums(body, cell, suite, Setting.ROBOT)
    except UsageError:
        return {}


def _body_of(motion: PolicyContract) -> Contender:
    return Contender(BLIND, BlindPolicy(len(motion.actions)), motion)


LIMITS: Mapping[str, Limit] = MappingProxyType({BLIND: blind_sums, ORACLE: best_sums})
