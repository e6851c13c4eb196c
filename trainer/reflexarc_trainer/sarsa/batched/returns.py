r"""λ-returns of a roll-out, backwards; compiled.

    G_t = r_t + γ [V_{t+1} + λ (G_{t+1} − Q_{t+1})],    G_T = Q_T,

where Q_{t+1} is the value of the action that was taken in the next place, and V_{t+1} is Q_{t+1}
itself (SARSA) or its mean over what ε-greedy may choose (expected SARSA). With V = Q this is
G_t = r_t + γ[(1 − λ) Q_{t+1} + λ G_{t+1}], whose TD-error form is the online learner's:
Σ δ_t e_t = Σ (G_t − Q_t) ∇Q_t for frozen weights. A contact cuts λ's reach; what comes after it
counts by V alone, or not at all where a contact is terminal.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused

Steps = npt.NDArray[Any]
"""Something of each step and agent: (steps, columns)."""


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
    """Fill `returns` (T, columns).

    Args:
        rewards: r_t: (T, columns).
        contacts: whether step t ended in a contact: (T, columns).
        taken: Q_t, from t = 0 to T; that of t = 0 is not used: (T + 1, columns).
        bootstraps: V_t, likewise.
        gamma: discount γ.
        trace_decay: λ.
        terminal: whether nothing counts after a contact.
        returns: G_t.
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
