"""The tabular case, worked by hand: SARSA(λ) over one-hot states is equation (1) with a trace.

Three states, two actions, α = 0.5, γ = 0.8, λ = 0.5, so γλ = 0.4. Q is 0 but for Q(1, 1) = 1.

1. (0, 0) pays 0.1, then (1, 1):   δ = 0.1 + 0.8·1 − 0 = 0.9
   e(0,0) = 1                      Q(0,0) = 0 + 0.5·0.9·1 = 0.45
2. (1, 1) pays 0.1, then (0, 0):   δ = 0.1 + 0.8·0.45 − 1 = −0.54
   e(0,0) = 0.4                    Q(0,0) = 0.45 − 0.27·0.4 = 0.342
   e(1,1) = 1                      Q(1,1) = 1 − 0.27 = 0.73
3. (0, 0) is a contact, −1, then (2, 0):   δ = −1 + 0.8·0 − 0.342 = −1.342
   e(0,0) = 0.16 + 1 = 1.16        Q(0,0) = 0.342 − 0.671·1.16 = −0.43636
   e(1,1) = 0.4                    Q(1,1) = 0.73 − 0.671·0.4 = 0.4616
   and the trace is cut.
4. (2, 0) pays 0.1, then (1, 1):   δ = 0.1 + 0.8·0.4616 − 0 = 0.46928
   e(2,0) = 1                      Q(2,0) = 0 + 0.5·0.46928 = 0.23464
"""

import dataclasses

import numpy as np
import pytest
import torch
from torch import nn

from reflexarc_trainer.config.train_config import LearnerConfig, OnlineConfig
from reflexarc_trainer.sarsa.online import traces
from reflexarc_trainer.sarsa.reference import SarsaLambda
from support.compiled_calls import from_python

accumulate = from_python(traces.accumulate)
move = from_python(traces.move)

CONFIG = LearnerConfig(gamma=0.8, trace_decay=0.5, online=OnlineConfig(alpha=0.5, step="literal"))
# state, action, reward, next state, next action, contact
WALK = [
    (0, 0, 0.1, 1, 1, False),
    (1, 1, 0.1, 0, 0, False),
    (0, 0, -1.0, 2, 0, True),
    (2, 0, 0.1, 1, 1, False),
]
TD_ERRORS = [0.9, -0.54, -1.342, 0.46928]
# rows are actions, columns are states
FINAL_Q = np.array([[-0.43636, 0.0, 0.23464], [0.0, 0.4616, 0.0]])


def table() -> nn.Linear:
    q = nn.Linear(3, 2, bias=False).double()
    with torch.no_grad():
        q.weight.copy_(torch.tensor([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    return q


def one_hot(state: int) -> torch.Tensor:
    return torch.eye(3, dtype=torch.float64)[state : state + 1]


def test_reference_learner_reproduces_the_hand_calculation() -> None:
    q = table()
    learner = SarsaLambda(q, CONFIG)
    td_errors = [
        learner.update(one_hot(s), a, r, one_hot(s2), a2, contact)
        for s, a, r, s2, a2, contact in WALK
    ]
    assert td_errors == pytest.approx(TD_ERRORS, abs=1e-12)
    np.testing.assert_allclose(q.weight.detach().numpy(), FINAL_Q, atol=1e-12)


def test_compiled_step_reproduces_the_hand_calculation() -> None:
    q, trace = table().weight.detach().numpy().copy().ravel(), np.zeros(6)
    for (s, a, _, _, _, contact), td_error in zip(WALK, TD_ERRORS, strict=True):
        gradient = np.eye(6)[3 * a + s]
        accumulate(trace, gradient, CONFIG.gamma * CONFIG.trace_decay)
        move(q, trace, CONFIG.online.alpha * td_error)
        trace *= not contact
    np.testing.assert_allclose(q.reshape(2, 3), FINAL_Q, atol=1e-12)


def test_terminal_contact_takes_no_value_from_the_place_after_it() -> None:
    q = table()
    learner = SarsaLambda(q, dataclasses.replace(CONFIG, after_contact="terminal"))
    assert learner.update(one_hot(0), 0, -1.0, one_hot(1), 1, True) == -1.0


def test_without_a_trace_only_the_visited_entry_moves() -> None:
    q = table()
    learner = SarsaLambda(q, dataclasses.replace(CONFIG, trace_decay=0.0))
    for s, a, r, s2, a2, contact in WALK[:2]:
        learner.update(one_hot(s), a, r, one_hot(s2), a2, contact)
    # Equation (1) twice: Q(0,0) = 0.45, then Q(1,1) = 1 + 0.5 (0.1 + 0.8·0.45 − 1).
    np.testing.assert_allclose(q.weight.detach().numpy(), [[0.45, 0, 0], [0, 0.73, 0]], atol=1e-12)


def test_expected_target_takes_the_mean_over_the_next_choice() -> None:
    q = table()
    learner = SarsaLambda(q, dataclasses.replace(CONFIG, target="expected"))
    # Q(1, ·) = (0, 1): 0.1 + 0.8 (0.7 · 1 + 0.3 · 0.5) − 0.
    td_error = learner.update(one_hot(0), 0, 0.1, one_hot(1), 0, False, epsilon=0.3)
    assert td_error == pytest.approx(0.78)


def test_centred_reward_follows_the_mean() -> None:
    learner = SarsaLambda(table(), dataclasses.replace(CONFIG, reward_centring=0.5, gamma=0.0))
    td_errors = [learner.update(one_hot(2), 0, 1.0, one_hot(2), 0, True) for _ in range(2)]
    # r̄ is 0, then 0.5; Q(2, 0) is 0, then 0.5.
    assert td_errors == pytest.approx([1.0, 0.0])


def test_intentional_step_removes_its_share_of_the_td_error() -> None:
    q = nn.Linear(3, 2).double()
    online = OnlineConfig(alpha=0.25, step="intentional")
    learner = SarsaLambda(q, dataclasses.replace(CONFIG, trace_decay=0.0, gamma=0.0, online=online))
    x = torch.tensor([[0.3, -0.2, 0.9]], dtype=torch.float64)
    td_error = learner.update(x, 1, 2.0, x, 1, False)
    assert 2.0 - float(q(x)[0, 1].detach()) == pytest.approx(0.75 * td_error)
