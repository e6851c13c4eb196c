"""One tick of a log, as its reader needs it: when it was, what was seen and preferred, and why."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.testing.shades import retina_lines
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True)
class TickMoment:
    """One tick, and what a policy says of it now."""

    tick: int
    time_s: float
    """Since the log's first tick."""
    retina: tuple[str, ...]
    """Lines of text."""
    recorded_q_values: tuple[float, ...]
    """Empty: the policy was not asked."""
    q_values: tuple[float, ...] | None
    """Of now; None: not known."""


def moment_at(log: Log, tick: int, policy: LoadedPolicy) -> TickMoment | None:
    """Find a tick; None if the log has none of that number.

    Raises:
        LogError: the log cannot be read.
    """
    first_ns: int | None = None
    for one in log.ticks():
        decision = one.decision
        first_ns = decision.now_ns if first_ns is None else first_ns
        if decision.index == tick:
            shape = policy.contract.retina.stack_shape
            return TickMoment(
                tick,
                (decision.now_ns - first_ns) / 1e9,
                tuple(retina_lines(decision.retina, shape)),
                tuple(decision.q_values),
                _asked_now(decision, policy),
            )
    return None


def lead_words(q_values: Sequence[float], actions: Sequence[str]) -> str:
    """Which action leads, which is the next one, and by how much."""
    order = sorted(range(len(q_values)), key=lambda i: (-q_values[i], i))
    names = [actions[i] if i < len(actions) else str(i) for i in order]
    if len(order) < 2:
        return "".join(names)
    lead = q_values[order[0]] - q_values[order[1]]
    return f"{names[0]} leads {names[1]} by {lead:.3g}"


def _asked_now(decision: Decision, policy: LoadedPolicy) -> tuple[float, ...] | None:
    contract = policy.contract
    if len(decision.retina) != contract.retina.frames * contract.retina.size:
        return None
    stack = np.frombuffer(decision.retina, np.uint8).reshape(1, *contract.retina.stack_shape)
    if contract.state.size:
        if len(decision.state) != contract.state.size:
            return None
        values = policy.decide(stack, np.array([decision.state], np.float32))[0]
    else:
        values = policy.decide(stack)[0]
    return tuple(values[0].tolist())
