"""Metric 10, how long decisions take: of one machine and one hour, so never part of a track.

One decision at a time, as a robot makes them, gives the median and the 99th percentile; a batch for
many agents at once gives decisions a second. What is looked at does not matter: it is drawn.
"""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender

if TYPE_CHECKING:
    from reflexarc_runtime.policy.policy import Policy, RememberingPolicy

DECISIONS, BATCH, BATCHES, WARM_UP = 1000, 64, 50, 20
_SHORTEST_S = 1e-9


class DecisionTimes(NamedTuple):
    """How long decisions of a contender take."""

    p50_us: float
    """Of one decision: median."""
    p99_us: float
    """The same, 99th percentile."""
    decisions_per_s: float
    """For many agents at once."""


def decision_times(
    contender: Contender, decisions: int = DECISIONS, now_s: Callable[[], float] = time.perf_counter
) -> DecisionTimes:
    """Measure a contender.

    Args:
        contender: whose decisions.
        decisions: how many, one at a time.
        now_s: a clock that never goes back.
    """
    alone_s = _durations_s(contender, 1, decisions, now_s)
    together_s = _durations_s(contender, BATCH, BATCHES, now_s)
    p50_s, p99_s = np.percentile(alone_s, (50.0, 99.0)).tolist()
    per_s = BATCH / max(float(np.median(together_s)), _SHORTEST_S)
    return DecisionTimes(1e6 * p50_s, 1e6 * p99_s, per_s)


def _durations_s(
    contender: Contender, agents: int, count: int, now_s: Callable[[], float]
) -> list[float]:
    """Of so many decisions for so many agents at once, after some that do not count."""
    shape = agents, *contender.contract.retina.stack_shape
    looks = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
    decide, durations_s = _decider(contender, agents), []
    for _ in range(WARM_UP + count):
        before_s = now_s()
        decide(looks)
        durations_s.append(now_s() - before_s)
    return durations_s[WARM_UP:]


def _decider(contender: Contender, agents: int) -> Callable[[RetinaBatch], Any]:
    memories = start_of(contender.contract, agents)
    if memories is None:
        return cast("Policy", contender.policy).decide
    remembering = cast("RememberingPolicy", contender.policy)
    return lambda looks: remembering.decide(looks, memories)
