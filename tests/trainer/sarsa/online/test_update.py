"""The compiled online learner against autograd, the readable one, and λ-returns."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import (
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
    TrainConfig,
)
from reflexarc_trainer.policy.q_network import QNetwork, new_network
from reflexarc_trainer.policy.weights import pack, unpack
from reflexarc_trainer.sarsa.exploration import new_streams
from reflexarc_trainer.sarsa.online import traces
from reflexarc_trainer.sarsa.online import update as online
from reflexarc_trainer.sarsa.online.learner import OnlineLearner, new_learning, rules_for, sizes_of
from reflexarc_trainer.sarsa.online.state import LearnerState, Rules, Scratch
from reflexarc_trainer.sarsa.online.update import AVERAGED_EVERY
from reflexarc_trainer.sarsa.online.weight_rows import from_online, to_online
from reflexarc_trainer.sarsa.reference import Body, learn
from support.compiled_calls import from_python
from support.precision import in_double

begin = from_python(online.begin)
fill_gradient = from_python(online.fill_gradient)
forward = from_python(online.forward)
learn_step = from_python(online.learn_step)
bounded_step = from_python(traces.bounded_step)
move_intentionally = from_python(traces.move_intentionally)

CONTRACT = TrainConfig().contract()
SIZES = sizes_of(TrainConfig())


def set_up(config: TrainConfig) -> tuple[Rules, LearnerState, Scratch]:
    return rules_for(config), *new_learning(config)


def transitions(
    body: Body, config: TrainConfig, rules: Rules, state: LearnerState, scratch: Scratch
) -> Iterator[tuple[int, bool, float]]:
    """The compiled learner, one visible transition after another: (action, contact, TD error)."""
    begin(rules, state, scratch, body.sense().ravel())
    for _ in range(config.steps):
        action = int(state.pending[0])
        contact = bool(body.step(np.array([action]))[0])
        reward = config.learner.reward_contact if contact else config.learner.reward_step
        retina = body.sense().ravel()
        yield action, contact, learn_step(rules, state, scratch, retina, contact, reward)


def gradient_of(network: QNetwork, retina: npt.NDArray[np.uint8], action: int) -> npt.NDArray[Any]:
    """∇Q(s, a) by autograd, in torch's order."""
    q = network(torch.from_numpy(retina.reshape(1, 1, 1, -1, 1)))[0, action]
    gradients = torch.autograd.grad(q, list(network.parameters()))
    return np.concatenate([g.numpy().ravel() for g in gradients])


def test_packing_and_unpacking_gives_the_same_network() -> None:
    config = NetworkConfig(hidden=(5, 4), initial_weights="normal")
    network = new_network(CONTRACT, config, seed=2)
    again = unpack(pack(network), CONTRACT, config)
    for mine, other in zip(network.parameters(), again.parameters(), strict=True):
        assert torch.equal(mine, other)


@pytest.mark.parametrize("hidden", [1, 10, 15, 16, 40])
def test_online_order_of_the_weights_leads_back(hidden: int) -> None:
    plain = np.arange(1.0, 17 * hidden + 3 * (hidden + 1) + 1)
    there = to_online(plain, 16, hidden, 3)
    np.testing.assert_array_equal(from_online(there, 16, hidden, 3), plain)
    assert np.count_nonzero(there) == len(plain)


@pytest.mark.parametrize("units", ["sigmoid", "tanh", "relu"])
@pytest.mark.parametrize("output", ["linear", "sigmoid"])
@pytest.mark.parametrize(("precision", "tolerance"), [("float64", 1e-12), ("float32", 1e-5)])
def test_compiled_value_and_gradient_are_those_of_autograd(
    units: Any, output: Any, precision: Any, tolerance: float
) -> None:
    network_config = NetworkConfig(
        units=units, output=output, initial_weights="normal", input_power=3
    )
    learner = LearnerConfig(online=OnlineConfig(precision=precision))
    config = TrainConfig(network=network_config, learner=learner)
    rules, _, scratch = set_up(config)
    network = new_network(CONTRACT, config.network, config.seed)
    for seed in range(20):
        retinas = np.random.default_rng(seed).integers(0, 256, (2, 16), np.uint8)
        scratch.inputs[:] = (retinas / 255) ** 3
        forward(rules, scratch)
        q_values = network(torch.from_numpy(retinas.reshape(2, 1, 1, 16, 1))).detach().numpy()
        np.testing.assert_allclose(scratch.q_values[:, :3], q_values, rtol=0, atol=tolerance)
        fill_gradient(rules, scratch, seed % 3)
        expected = gradient_of(network, retinas[0], seed % 3)
        mine = from_online(scratch.gradient, *SIZES)
        np.testing.assert_allclose(mine, expected, rtol=0, atol=tolerance)


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
    name: str, recorded_body: Callable[..., Body]
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


@pytest.mark.parametrize("action_repeat", [1, 3])
def test_compiled_learner_equals_the_reference_in_a_world(action_repeat: int) -> None:
    explore = ExplorationConfig(action_repeat=action_repeat)
    learner_config = LearnerConfig(exploration=explore, reward_centring=0.01)
    config = in_double(TrainConfig(steps=600, seed=11, learner=learner_config))
    learner = OnlineLearner(config)
    learner.run(config.steps)

    body = Simulation(config.goal_world, config.contract(), np.array([11], np.uint64))
    network = new_network(config.contract(), config.network, config.seed)
    list(learn(network, body, config.learner, new_streams(11), config.steps))
    np.testing.assert_allclose(learner.weights, pack(network), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_single_precision_learns_the_same_but_for_rounding(
    name: str, recorded_body: Callable[..., Body]
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


def test_a_vanishing_trace_moves_nothing() -> None:
    """The intentional step divides by Σ s e², which single precision would lose."""
    weights, trace = np.ones(32, np.float32), np.full(32, 1e-21, np.float32)
    trace[16:] = 0.0
    nothing = np.zeros_like(weights)
    move_intentionally(weights, trace, nothing.copy(), nothing, 0.5)
    np.testing.assert_array_equal(weights, 1.0)


def test_averaged_weights_are_what_is_learned(recorded_body: Callable[..., Body]) -> None:
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
    recorded_body: Callable[..., Body],
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
    actions.append(int(state.pending[0]))
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


@settings(deadline=None)  # the first call compiles
@given(
    trace=st.lists(st.floats(-50, 50), min_size=4, max_size=40),
    td_error=st.floats(-100, 100),
    data=st.data(),
)
def test_bounded_step_never_overshoots(trace: list[float], td_error: float, data: Any) -> None:
    """A linear value with features in [−1, 1] moves by at most 1/κ of the TD error."""
    features = data.draw(st.lists(st.floats(-1, 1), min_size=len(trace), max_size=len(trace)))
    step = bounded_step(1000.0, 2.0, td_error, math.fsum(map(abs, trace)))
    correction = step * td_error * np.dot(trace, features)
    assert abs(correction) <= abs(td_error) / 2.0 * (1 + 1e-9)


def test_bounded_step_is_never_above_alpha() -> None:
    assert bounded_step(0.5, 2.0, 0.1, 1e-3) == 0.5
    assert bounded_step(0.5, 2.0, 0.1, 0.0) == 0.5
    assert bounded_step(0.5, 2.0, 4.0, 5.0) == 1 / (2 * 4 * 5)


def test_held_actions_are_repeated_until_a_contact(recorded_body: Callable[..., Body]) -> None:
    explore = ExplorationConfig(held_actions=4, epsilon_end=1.0)
    config = TrainConfig(steps=400, learner=LearnerConfig(exploration=explore))
    rows = list(transitions(recorded_body(1, 400), config, *set_up(config)))
    left, previous = 0, -1
    for action, contact, _ in rows:
        assert left == 0 or action == previous
        left = 0 if contact else (explore.held_actions if left == 0 else left) - 1
        previous = action
    assert {action for action, _, _ in rows} == {0, 1, 2}


def test_report_counts_every_contact_of_a_repeated_action() -> None:
    explore = ExplorationConfig(action_repeat=3, epsilon_start=1.0, epsilon_end=1.0)
    learner = OnlineLearner(TrainConfig(learner=LearnerConfig(exploration=explore)))
    learner.run(500)
    learner.mark()
    before = learner._simulation.contacts[0], learner._simulation.distance_m[0]
    learner.run(2000)
    contacts = learner._simulation.contacts[0] - before[0]
    distance_m = learner._simulation.distance_m[0] - before[1]
    assert contacts > 100
    assert learner.report().contacts_per_100m == pytest.approx(100.0 * contacts / distance_m)


def test_a_run_that_goes_on_from_its_arrays_has_the_same_bits() -> None:
    """With everything that the step by RMS, single precision and repeated actions keep."""
    config = dataclasses.replace(PRESETS["reflex-online"], steps=3000, seed=5)
    whole, first, second = (OnlineLearner(config) for _ in range(3))
    whole.run(3000)
    first.run(1237)
    second.restore({name: array.copy() for name, array in first.arrays().items()})
    second.run(3000 - 1237)
    for name, array in whole.arrays().items():
        np.testing.assert_array_equal(second.arrays()[name], array, err_msg=name)
