"""The compiled online update against the reference and against λ-returns."""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch

from reflexarc_trainer.config.train_config import (
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
    TrainConfig,
)
from reflexarc_trainer.policy.q_network import QNetwork, new_network
from reflexarc_trainer.policy.weights import pack
from reflexarc_trainer.sarsa.exploration import new_streams
from reflexarc_trainer.sarsa.online import update
from reflexarc_trainer.sarsa.online.learner import sizes_of
from reflexarc_trainer.sarsa.online.state import LearnerState, Rules, Scratch
from reflexarc_trainer.sarsa.online.update import AVERAGED_EVERY
from reflexarc_trainer.sarsa.online.weight_rows import from_online
from reflexarc_trainer.sarsa.reference import AgentBody, learn
from support.compiled_calls import from_python
from support.learning import gradient_of, set_up
from support.precision import in_double

begin = from_python(update.begin)
learn_step = from_python(update.learn_step)
CONTRACT = TrainConfig().contract()
SIZES = sizes_of(TrainConfig())


def transitions(
    body: AgentBody, config: TrainConfig, rules: Rules, state: LearnerState, scratch: Scratch
) -> Iterator[tuple[int, bool, float]]:
    """The compiled learner, one visible transition after another: (action, contact, TD error)."""
    begin(rules, state, scratch, body.sense().ravel())
    for _ in range(config.steps):
        action = int(state.action[0])
        contact = bool(body.step(np.array([action]))[0])
        reward = config.learner.reward_contact if contact else config.learner.reward_step
        retina = body.sense().ravel()
        yield action, contact, learn_step(rules, state, scratch, retina, contact, reward)


KEEPING = ExplorationConfig(epsilon_span=0.1, least_lead=0.02)
CASES: dict[str, TrainConfig] = {
    "as the paper": TrainConfig(),
    "literal": TrainConfig(learner=LearnerConfig(online=OnlineConfig(step="literal"))),
    "linear, held": TrainConfig(
        network=NetworkConfig(output="linear"),
        learner=LearnerConfig(exploration=ExplorationConfig(held_actions=3)),
    ),
    "terminal": TrainConfig(learner=LearnerConfig(after_contact="terminal", trace_decay=0.5)),
    "7 tanh units": TrainConfig(
        network=NetworkConfig(hidden=(7,), units="tanh", initial_weights="normal", input_power=2)
    ),
    "20 relu units": TrainConfig(
        network=NetworkConfig(hidden=(20,), units="relu", output="linear"),
        learner=LearnerConfig(online=OnlineConfig(alpha=0.1, alpha_end=0.1)),
    ),
    "expected, centred": TrainConfig(
        learner=LearnerConfig(target="expected", reward_centring=0.01)
    ),
    "a least lead, switches cost": TrainConfig(
        learner=LearnerConfig(exploration=KEEPING, reward_switch=-0.05)
    ),
    "a margin, expected, switches cost": TrainConfig(
        learner=LearnerConfig(
            target="expected",
            exploration=ExplorationConfig(epsilon_span=0.1, margin=0.5),
            reward_switch=-0.1,
        )
    ),
    "rmsprop": TrainConfig(
        network=NetworkConfig(hidden=(20,), units="relu", output="linear"),
        learner=LearnerConfig(online=OnlineConfig(alpha=1e-3, step="rmsprop", alpha_end=0.5)),
    ),
    "intentional": TrainConfig(
        learner=LearnerConfig(online=OnlineConfig(alpha=0.05, step="intentional", alpha_end=0.5))
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_compiled_learner_equals_the_reference_on_the_same_stream(
    name: str, recorded_body: Callable[..., AgentBody]
) -> None:
    config = in_double(dataclasses.replace(CASES[name], steps=500, seed=1))
    rules, state, scratch = set_up(config)
    compiled = list(transitions(recorded_body(7, 500), config, rules, state, scratch))

    network = new_network(CONTRACT, config.network, config.seed)
    streams = new_streams(config.seed)
    reference = list(learn(network, recorded_body(7, 500), config.learner, streams, 500))

    assert [action for action, _, _ in compiled] == [t.action for t in reference]
    expected = [t.td_error for t in reference]
    np.testing.assert_allclose([d for _, _, d in compiled], expected, rtol=0, atol=1e-9)
    mine = from_online(state.weights, 16, config.network.hidden[0], 3)
    np.testing.assert_allclose(mine, pack(network), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_single_precision_learns_the_same_but_for_rounding(
    name: str, recorded_body: Callable[..., AgentBody]
) -> None:
    case = dataclasses.replace(CASES[name], steps=40, seed=1)
    runs = []
    for precision in ("float64", "float32"):
        online = dataclasses.replace(case.learner.online, precision=precision)
        learner = dataclasses.replace(case.learner, online=online, averaged_weights=0.9)
        config = dataclasses.replace(case, learner=learner)
        rules, state, scratch = set_up(config)
        assert state.weights.dtype == scratch.q_values.dtype == precision
        errors = [d for _, _, d in transitions(recorded_body(7, 40), config, rules, state, scratch)]
        runs.append((errors, state.weights, state.averaged))
    for double, single in zip(*runs, strict=True):
        np.testing.assert_allclose(single, double, rtol=0, atol=1e-4)


def test_averaged_weights_are_what_is_learned(recorded_body: Callable[..., AgentBody]) -> None:
    keep, learner = 0.999, LearnerConfig(averaged_weights=0.999)
    config = in_double(TrainConfig(steps=3000, learner=learner))
    rules, state, scratch = set_up(config)
    average = state.weights.copy()
    rows = transitions(recorded_body(7, 3000), config, rules, state, scratch)
    for step, _ in enumerate(rows, start=1):
        if step % AVERAGED_EVERY == 0:
            share = max(1 - keep**AVERAGED_EVERY, 10 / (10 + step / AVERAGED_EVERY))
            average += share * (state.weights - average)
    assert np.abs(state.weights - average).max() > 1e-3
    np.testing.assert_allclose(state.averaged, average, rtol=0, atol=1e-12)


def test_td_errors_times_traces_sum_to_the_lambda_returns(
    recorded_body: Callable[..., AgentBody],
) -> None:
    """With frozen weights Σ δ_t e_t = Σ (G_t − Q_t) ∇Q_t, where a contact ends λ's reach."""
    learner = LearnerConfig(online=OnlineConfig(step="literal"))
    config = in_double(TrainConfig(steps=60, learner=learner))
    rules, state, scratch = set_up(config)
    rules, body = rules._replace(alpha=0.0, alpha_end=0.0), recorded_body(3, 60, 0.1)
    network = new_network(CONTRACT, config.network, config.seed)
    decay = config.learner.gamma * config.learner.trace_decay
    total, before = np.zeros(203), np.zeros(203)
    seen: list[Any] = [body.sense().copy()]
    actions, cuts = [], []
    for action, contact, td_error in transitions(body, config, rules, state, scratch):
        # The cut comes after the update: rebuild the trace that the update used.
        total += td_error * (decay * before + gradient_of(network, seen[-1], action))
        before = from_online(state.trace, *SIZES)
        seen.append(body.sense().copy())
        actions.append(action)
        cuts.append(contact)
    actions.append(int(state.action[0]))
    expected = lambda_returns_sum(config.learner, network, seen, actions, cuts)
    np.testing.assert_allclose(total, expected, atol=1e-10)


def lambda_returns_sum(
    config: LearnerConfig, network: QNetwork, seen: list[Any], actions: list[int], cuts: list[bool]
) -> npt.NDArray[Any]:
    """Σ (G_t − Q_t) ∇Q_t with G_t = r_t + γ[(1 − λ) Q_{t+1} + λ G_{t+1}]."""
    retinas = torch.from_numpy(np.array(seen).reshape(-1, 1, 1, 16, 1))
    q = network(retinas).detach().numpy()[np.arange(len(actions)), actions]
    total, g = np.zeros(203), q[-1]
    for t in reversed(range(len(cuts))):
        reach = 0.0 if cuts[t] else config.trace_decay
        reward = config.reward_contact if cuts[t] else config.reward_step
        g = reward + config.gamma * ((1 - reach) * q[t + 1] + reach * g)
        total += (g - q[t]) * gradient_of(network, seen[t], actions[t])
    return total


def test_held_actions_are_repeated_until_a_contact(recorded_body: Callable[..., AgentBody]) -> None:
    explore = ExplorationConfig(held_actions=4, epsilon_end=1.0)
    config = TrainConfig(steps=400, learner=LearnerConfig(exploration=explore))
    rows = list(transitions(recorded_body(1, 400), config, *set_up(config)))
    left, previous = 0, -1
    for action, contact, _ in rows:
        assert left == 0 or action == previous
        left = 0 if contact else (explore.held_actions if left == 0 else left) - 1
        previous = action
    assert {action for action, _, _ in rows} == {0, 1, 2}
