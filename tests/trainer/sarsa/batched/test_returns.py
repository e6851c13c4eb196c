"""λ-returns against their definition as a mixture of n-step returns."""

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_trainer.sarsa.batched import returns
from support.compiled_calls import from_python

lambda_returns = from_python(returns.lambda_returns)

GAMMA, TRACE_DECAY, STEPS, COLUMNS = 0.9, 0.7, 12, 5
Arrays = tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.float64]]


def draw() -> Arrays:
    generator = np.random.default_rng(4)
    contacts = generator.random((STEPS, COLUMNS)) < 0.15
    rewards = np.where(contacts, -1.0, 0.1)
    return rewards, contacts, generator.normal(size=(STEPS + 1, COLUMNS))


def slow_return(arrays: Arrays, t: int, column: int, terminal: bool) -> float:
    """(1 − λ) Σ λⁿ⁻¹ G⁽ⁿ⁾, the last n-step return with all the weight that is left."""
    rewards, contacts, q = (a[:, column] for a in arrays)
    total, weight, so_far, n = 0.0, 1.0, 0.0, 0
    while True:
        so_far += GAMMA**n * rewards[t + n]
        n += 1
        met = contacts[t + n - 1]
        worth = 0.0 if met and terminal else q[t + n]
        n_step = so_far + GAMMA**n * worth
        if met or t + n == STEPS:
            return float(total + weight * n_step)
        total += weight * (1 - TRACE_DECAY) * n_step
        weight *= TRACE_DECAY


@pytest.mark.parametrize("terminal", [False, True])
def test_return_is_the_mixture_of_n_step_returns(terminal: bool) -> None:
    rewards, contacts, q = arrays = draw()
    returns = np.zeros_like(rewards)
    lambda_returns(rewards, contacts, q, q, GAMMA, TRACE_DECAY, terminal, returns)
    expected = [[slow_return(arrays, t, c, terminal) for c in range(COLUMNS)] for t in range(STEPS)]
    np.testing.assert_allclose(returns, expected, rtol=0, atol=1e-12)


def test_expected_form_differs_from_the_sampled_one_by_what_the_choice_adds() -> None:
    """G = r + γ[V + λ(G′ − Q′)], column by column as written."""
    rewards, contacts, q = draw()
    v, returns = q + 0.3, np.zeros_like(rewards)
    lambda_returns(rewards, contacts, q, v, GAMMA, TRACE_DECAY, False, returns)
    g = q[-1].copy()
    for t in reversed(range(STEPS)):
        reach = np.where(contacts[t], 0.0, TRACE_DECAY)
        g = rewards[t] + GAMMA * (v[t + 1] + reach * (g - q[t + 1]))
        np.testing.assert_allclose(returns[t], g, rtol=0, atol=1e-12)
