"""The compiled learner against autograd, against the readable one, and against λ-returns."""

import copy
import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named
from reflexarc_trainer.choice import new_stream
from reflexarc_trainer.config import LearnerConfig, TrainConfig
from reflexarc_trainer.learner import OnlineLearner, rules_for
from reflexarc_trainer.online import (
    LearnerState,
    Rules,
    Scratch,
    add_gradient,
    begin,
    forward,
    learn_step,
    new_scratch,
    new_state,
    step_size,
)
from reflexarc_trainer.q_network import QNetwork, new_network
from reflexarc_trainer.reference import Body, learn
from reflexarc_trainer.weights import pack, unpack

CONTRACT = TrainConfig().contract()
Run = tuple[LearnerState, list[float], list[int]]


def set_up(
    config: LearnerConfig, steps: int = 1, **changes: Any
) -> tuple[Rules, LearnerState, Scratch]:
    rules = rules_for(config, CONTRACT, steps)._replace(**changes)
    weights = pack(new_network(CONTRACT, config, seed=1))
    return rules, new_state(rules, weights, new_stream(5)), new_scratch(rules)


def look(body: Body, scratch: Scratch) -> None:
    scratch.retina[:] = body.sense().ravel()


def transitions(
    body: Body, steps: int, rules: Rules, state: LearnerState, scratch: Scratch
) -> Iterator[tuple[int, bool, float]]:
    """The compiled learner, one visible transition after another: (action, contact, TD error)."""
    look(body, scratch)
    begin(rules, state, scratch)
    for _ in range(steps):
        action = int(state.pending[0])
        contact = bool(body.step(np.array([action]))[0])
        look(body, scratch)
        yield action, contact, learn_step(rules, state, scratch, contact)


def gradient_of(network: QNetwork, retina: npt.NDArray[np.uint8], action: int) -> npt.NDArray[Any]:
    """∇Q(s, a) by autograd, in the compiled layout."""
    network.zero_grad()
    network(torch.from_numpy(retina.reshape(1, 1, 1, -1, 1)))[0, action].backward()
    gradient = copy.deepcopy(network)
    with torch.no_grad():
        for mine, parameter in zip(gradient.parameters(), network.parameters(), strict=True):
            assert parameter.grad is not None
            mine.copy_(parameter.grad)
    return pack(gradient)


def test_packing_and_unpacking_gives_the_same_network() -> None:
    config = LearnerConfig(initial_weights="normal")
    network = new_network(CONTRACT, config, seed=2)
    again = unpack(pack(network), CONTRACT, config)
    for mine, other in zip(network.parameters(), again.parameters(), strict=True):
        assert torch.equal(mine, other)


@pytest.mark.parametrize("output", ["linear", "sigmoid"])
def test_compiled_value_and_gradient_are_those_of_autograd(output: Any) -> None:
    config = LearnerConfig(output=output, initial_weights="normal")
    rules, state, scratch = set_up(config)
    network = new_network(CONTRACT, config, seed=1)
    for seed in range(20):
        retina = np.random.default_rng(seed).integers(0, 256, 16, np.uint8)
        state.inputs[:-1] = retina / 255
        state.trace[:] = 0.0
        forward(rules, state.weights, state.inputs, scratch.hidden, scratch.q_values)
        add_gradient(rules, state, scratch, seed % 3)
        q_values = network(torch.from_numpy(retina.reshape(1, 1, 1, 16, 1))).detach().numpy()[0]
        np.testing.assert_allclose(scratch.q_values, q_values, rtol=0, atol=1e-12)
        expected = gradient_of(network, retina, seed % 3)
        np.testing.assert_allclose(state.trace, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"step": "literal"},
        {"output": "linear", "held_actions": 3},
        {"after_contact": "terminal", "trace_decay": 0.5},
        {"initial_weights": "normal", "hidden": 7},
    ],
    ids=str,
)
def test_compiled_learner_equals_the_reference_on_the_same_stream(
    changes: dict[str, Any], recorded_body: Callable[..., Body]
) -> None:
    steps, config = 500, dataclasses.replace(LearnerConfig(), **changes)
    rules, state, scratch = set_up(config, steps)
    compiled = list(transitions(recorded_body(7, steps), steps, rules, state, scratch))

    network = new_network(CONTRACT, config, seed=1)
    reference = list(learn(network, recorded_body(7, steps), config, new_stream(5), steps))

    assert [action for action, _, _ in compiled] == [t.action for t in reference]
    expected = [t.td_error for t in reference]
    np.testing.assert_allclose([d for _, _, d in compiled], expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(state.weights, pack(network), rtol=0, atol=1e-9)


def test_compiled_learner_equals_the_reference_in_a_world() -> None:
    config = TrainConfig(steps=600, seed=11)
    learner = OnlineLearner(config)
    learner.run(config.steps)

    body = Simulation(world_named(config.world), config.contract(), np.array([11], np.uint64))
    network = new_network(config.contract(), config.learner, config.seed)
    list(learn(network, body, config.learner, new_stream(11), config.steps))
    np.testing.assert_allclose(learner.weights, pack(network), rtol=0, atol=1e-9)


def test_td_errors_times_traces_sum_to_the_lambda_returns(
    recorded_body: Callable[..., Body],
) -> None:
    """With frozen weights Σ δ_t e_t = Σ (G_t − Q_t) ∇Q_t, where a contact ends λ's reach."""
    steps, config = 60, LearnerConfig(step="literal")
    frozen = set_up(config, steps, alpha=0.0)
    body, total = recorded_body(3, steps, 0.1), np.zeros(frozen[0].parameters)
    seen, rewards, cuts = [], [], []
    rules, state, scratch = frozen
    look(body, scratch)
    begin(rules, state, scratch)
    for _ in range(steps):
        seen.append((scratch.retina.copy(), int(state.pending[0])))
        contact = bool(body.step(np.array([0]))[0])
        look(body, scratch)
        before = state.trace.copy()
        td_error = learn_step(rules, state, scratch, contact)
        rewards.append(config.reward_contact if contact else config.reward_step)
        cuts.append(contact)
        # The cut comes after the update: rebuild the trace that the update used.
        decay = config.gamma * config.trace_decay
        network = new_network(CONTRACT, config, seed=1)
        trace = decay * before + gradient_of(network, *seen[-1])
        total += td_error * trace
    seen.append((scratch.retina.copy(), int(state.pending[0])))
    np.testing.assert_allclose(total, lambda_returns_sum(config, seen, rewards, cuts), atol=1e-10)


def lambda_returns_sum(
    config: LearnerConfig, seen: list[Any], rewards: list[float], cuts: list[bool]
) -> npt.NDArray[Any]:
    """Σ (G_t − Q_t) ∇Q_t with G_t = r_t + γ[(1 − λ) Q_{t+1} + λ G_{t+1}]."""
    network = new_network(CONTRACT, config, seed=1)
    q = [
        float(network(torch.from_numpy(s.reshape(1, 1, 1, 16, 1)))[0, a].detach()) for s, a in seen
    ]
    total, g = np.zeros(len(pack(network))), q[-1]
    for t in reversed(range(len(rewards))):
        reach = 0.0 if cuts[t] else config.trace_decay
        g = rewards[t] + config.gamma * ((1 - reach) * q[t + 1] + reach * g)
        total += (g - q[t]) * gradient_of(network, *seen[t])
    return total


@given(
    trace=st.lists(st.floats(-50, 50), min_size=4, max_size=40),
    td_error=st.floats(-100, 100),
    data=st.data(),
)
def test_bounded_step_never_overshoots(trace: list[float], td_error: float, data: Any) -> None:
    """A linear value with features in [−1, 1] moves by at most 1/κ of the TD error."""
    features = data.draw(st.lists(st.floats(-1, 1), min_size=len(trace), max_size=len(trace)))
    rules = rules_for(LearnerConfig(alpha=1000.0), CONTRACT, 1)
    step = step_size(rules, np.array(trace), td_error)
    correction = step * td_error * np.dot(trace, features)
    assert abs(correction) <= abs(td_error) / rules.kappa * (1 + 1e-9)


def test_bounded_step_is_never_above_alpha() -> None:
    rules = rules_for(LearnerConfig(alpha=0.5), CONTRACT, 1)
    assert step_size(rules, np.array([1e-3]), 0.1) == 0.5
    assert step_size(rules, np.zeros(3), 0.1) == 0.5
    assert step_size(rules, np.array([2.0, -3.0]), 4.0) == 1 / (2 * 4 * 5)


def test_held_actions_are_repeated_until_a_contact(recorded_body: Callable[..., Body]) -> None:
    config = LearnerConfig(held_actions=4, epsilon_end=1.0)
    rows = list(transitions(recorded_body(1, 400), 400, *set_up(config, 400)))
    left, previous = 0, -1
    for action, contact, _ in rows:
        assert left == 0 or action == previous
        left = 0 if contact else (config.held_actions if left == 0 else left) - 1
        previous = action
    assert {action for action, _, _ in rows} == {0, 1, 2}
