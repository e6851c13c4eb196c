r"""λ-returns of a roll-out, computed backwards from its end; compiled.

    G_t = r_t + γ [V_{t+1} + λ (G_{t+1} − Q_{t+1})],    G_T = Q_T,

where Q_t is the value of the action taken in state t, and V_t is Q_t itself (SARSA) or the
expectation over the ε-greedy choice (expected SARSA). With V = Q this is the λ-return

    G_t = r_t + γ [(1 − λ) Q_{t+1} + λ G_{t+1}]

(Sutton & Barto, Reinforcement Learning, 2nd edition, 2018, ch. 12), which for constant weights
makes the same update as the online learner's traces: Σ δ_t e_t = Σ (G_t − Q_t) ∇Q_t. After a
contact λ counts as 0, for the trace is cut there; γ does too, where a contact is terminal.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused

Steps = npt.NDArray[Any]
"""A number per step and agent, float32 or float64: (steps, columns)."""


@fused
def lambda_returns(
    rewards: Steps,
    contacts: npt.NDArray[np.bool_],
    taken: Steps,
    bootstraps: Steps,
    gamma: float,
    trace_decay: float,
    terminal: bool,
    returns: Steps,
) -> None:
    """Fill `returns`.

    Args:
        rewards: r_t: (T, columns).
        contacts: whether transition t ended in a contact: (T, columns).
        taken: Q_t for t = 0 to T; that of t = 0 is not used: (T + 1, columns).
        bootstraps: V_t, likewise: (T + 1, columns).
        gamma: discount γ.
        trace_decay: λ.
        terminal: whether V counts as 0 after a contact.
        returns: G_t, filled: (T, columns).
    """
    number = returns.dtype.type
    discount, reach, none = number(gamma), number(gamma * trace_decay), number(0)
    after = none if terminal else discount
    for t in range(len(rewards) - 1, -1, -1):
        last = t == len(rewards) - 1
        for c in range(rewards.shape[1]):
            beyond = none if last else returns[t + 1, c] - taken[t + 1, c]
            met = contacts[t, c]
            ahead = (after if met else discount) * bootstraps[t + 1, c]
            returns[t, c] = rewards[t, c] + ahead + (none if met else reach * beyond)
