"""The batched form: its roll-outs, its gradient, and that threads change nothing."""

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_trainer.config.train_config import BatchedConfig, ExplorationConfig, TrainConfig
from reflexarc_trainer.policy.weights import NetworkPolicy, network_of
from reflexarc_trainer.sarsa.batched import network_pass as block
from reflexarc_trainer.sarsa.batched import returns
from reflexarc_trainer.sarsa.batched import update as batched
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner, _seeds, pace_of
from reflexarc_trainer.sarsa.batched.rollout import Rollout, new_rollout
from reflexarc_trainer.sarsa.batched.update import Sums
from reflexarc_trainer.sarsa.network_shape import Layers, layers_for
from reflexarc_trainer.sarsa.online import traces
from reflexarc_trainer.sarsa.online import update as online
from reflexarc_trainer.sarsa.online.learner import new_learning, rules_for, sizes_of
from reflexarc_trainer.sarsa.online.weight_rows import from_online, to_online
from support.compiled_calls import from_python
from support.precision import in_double

batch_forward = from_python(block.forward)
shard_gradient = from_python(batched.shard_gradient)
fill_gradient = from_python(online.fill_gradient)
forward = from_python(online.forward)
lambda_returns = from_python(returns.lambda_returns)
accumulate = from_python(traces.accumulate)


def with_batched(config: TrainConfig, **changes: object) -> TrainConfig:
    batched = dataclasses.replace(config.learner.batched, **changes)  # type: ignore[arg-type]  # by name
    return dataclasses.replace(config, learner=dataclasses.replace(config.learner, batched=batched))


def first_actions(learner: BatchedLearner) -> npt.NDArray[np.int64]:
    """Of the roll-out that was done last, all agents' in a row: (agents,)."""
    return learner._learning.rollout.actions[:, 0].ravel()


def test_first_actions_are_chosen_by_the_network_for_what_is_seen(
    small_batched_config: TrainConfig,
) -> None:
    greedy = ExplorationConfig(epsilon_start=0.0, epsilon_end=0.0)
    learner = dataclasses.replace(small_batched_config.learner, exploration=greedy)
    config = dataclasses.replace(small_batched_config, learner=learner, seed=5)
    agents = BatchedLearner(config)
    best = NetworkPolicy(network_of(agents)).decide(agents._simulation.stacks.copy())[1]
    agents.run(160)
    assert len(set(best.tolist())) > 1
    np.testing.assert_array_equal(first_actions(agents), best)


def test_first_actions_explore(small_batched_config: TrainConfig) -> None:
    agents = BatchedLearner(with_batched(small_batched_config, agents=64))
    agents.run(640)
    assert set(first_actions(agents).tolist()) == {0, 1, 2}


def test_same_bits_on_one_thread_and_on_two(small_batched_config: TrainConfig) -> None:
    learned = []
    for threads in (1, 2):
        set_thread_count(threads)
        learner = BatchedLearner(small_batched_config)
        learner.run(1600)
        learned.append({name: a.tobytes() for name, a in learner.arrays().items()})
    assert learned[0] == learned[1]


def test_bootstrap_action_is_the_first_one_executed_next(small_batched_config: TrainConfig) -> None:
    explore = ExplorationConfig(epsilon_end=1.0)
    learner = BatchedLearner(
        dataclasses.replace(
            small_batched_config,
            learner=dataclasses.replace(small_batched_config.learner, exploration=explore),
        )
    )
    rollout = learner._learning.rollout
    learner.run(160)
    for _ in range(5):
        last = rollout.actions[:, -1].copy(), rollout.inputs[:, -1].copy()
        learner.run(160)
        np.testing.assert_array_equal(rollout.actions[:, 0], last[0])
        np.testing.assert_array_equal(rollout.inputs[:, 0], last[1])
    assert set(rollout.actions.ravel()) == {0, 1, 2}


def test_rewards_say_what_met_an_obstacle(small_batched_config: TrainConfig) -> None:
    learner = BatchedLearner(small_batched_config)
    learner.run(1600)
    before = learner._simulation.contacts.sum()
    average_reward = learner._learning.sums.progress[1]
    learner.run(160)
    rollout = learner._learning.rollout
    assert rollout.contacts.sum() == learner._simulation.contacts.sum() - before
    expected = np.where(rollout.contacts, -1.0, 0.1) - average_reward
    np.testing.assert_allclose(rollout.rewards, expected, atol=1e-6)


def test_a_repeated_action_brings_what_its_steps_bring(small_batched_config: TrainConfig) -> None:
    """Against the world, step by step, with the actions that were chosen."""
    config = small_batched_config
    explore = ExplorationConfig(epsilon_start=1.0, epsilon_end=1.0, action_repeat=3)
    learner_config = dataclasses.replace(config.learner, exploration=explore, reward_centring=0.0)
    learner = BatchedLearner(dataclasses.replace(config, learner=learner_config))
    learner.run(1600)
    world = Simulation(learner.config.goal_world, learner.contract, _seeds(learner.config))
    world.restore(learner._simulation.state())
    learner.run(1)
    rollout = learner._learning.rollout
    actions, rewards, contacts = (
        np.moveaxis(rows, 1, 0).reshape(rows.shape[1], -1)
        for rows in (rollout.actions, rollout.rewards, rollout.contacts)
    )
    for t in range(len(rewards)):
        met = np.array([world.step(actions[t]) for _ in range(3)])
        np.testing.assert_array_equal(contacts[t], met.any(axis=0))
        np.testing.assert_allclose(rewards[t], np.where(met, -1.0, 0.1).sum(axis=0), rtol=1e-6)
    assert contacts.any()
    np.testing.assert_array_equal(world.x_m, learner._simulation.x_m)
    world.sense()
    np.testing.assert_array_equal(world.stacks, learner._simulation.stacks)


def test_a_repeated_action_is_not_held_as_well() -> None:
    with pytest.raises(UsageError, match=r"held_actions: expected 1 where .*action_repeat"):
        ExplorationConfig(action_repeat=2, held_actions=2)


def recorded_rollout(layers: Layers, steps: int) -> Rollout:
    """A roll-out of one agent that no world gave: random inputs, actions and contacts."""
    generator = np.random.default_rng(8)
    rollout = new_rollout(1, steps, 1, layers, np.float64)
    rollout.inputs[:] = generator.random(rollout.inputs.shape)
    rollout.actions[:] = generator.integers(0, 3, rollout.actions.shape)
    rollout.contacts[:] = generator.random(rollout.contacts.shape) < 0.1
    rollout.rewards[:] = np.where(rollout.contacts, -1.0, 0.1)
    return rollout


def test_gradient_is_the_sum_of_td_errors_times_traces(small_batched_config: TrainConfig) -> None:
    """The oracle that ties both forms: Σ δ_t e_t = Σ (G_t − Q_t) ∇Q_t with frozen weights."""
    config = with_batched(small_batched_config, agents=1, shard_agents=1, minibatches=1)
    config = in_double(config)
    layers = layers_for(config.network, config.contract())
    rollout = recorded_rollout(layers, 100)
    weights = np.random.default_rng(9).normal(size=layers.parameters)
    values = np.zeros((layers.computed, 1))
    for t in range(101):
        batch_forward(layers, weights, rollout.inputs[0, t], values)
        rollout.taken[0, t] = values[-3:][rollout.actions[0, t, 0]]
    learner, taken = config.learner, rollout.taken[0]
    lambda_returns(
        rollout.rewards[0],
        rollout.contacts[0],
        taken,
        taken,
        learner.gamma,
        learner.trace_decay,
        False,
        rollout.returns[0],
    )
    sums = Sums(
        weights=weights,
        averaged=weights.copy(),
        back=np.zeros((1, layers.computed, 1)),
        gradients=np.zeros((1, layers.parameters)),
        errors=np.zeros(1),
        progress=np.zeros(2),
    )
    shard_gradient(layers, pace_of(config), rollout, sums, 0, 0)
    total = online_sum(config, weights, rollout)
    np.testing.assert_allclose(-sums.gradients[0], total, rtol=0, atol=1e-10)


def online_sum(
    config: TrainConfig, frozen: npt.NDArray[np.float64], rollout: Rollout
) -> npt.NDArray[np.float64]:
    """Σ δ_t e_t by the online learner's own forward pass, gradient and trace."""
    rules, (state, scratch) = rules_for(config), new_learning(config)
    state.weights[:] = to_online(frozen, *sizes_of(config))
    inputs, actions = rollout.inputs[0, :, :, 0], rollout.actions[0, :, 0]
    total = np.zeros_like(state.trace)
    for t, (contact, reward) in enumerate(
        zip(rollout.contacts[0, :, 0], rollout.rewards[0, :, 0], strict=True)
    ):
        scratch.inputs[:] = inputs[t : t + 2]
        forward(rules, scratch)
        target = reward + rules.gamma * scratch.q_values[1, actions[t + 1]]
        td_error = target - scratch.q_values[0, actions[t]]
        fill_gradient(rules, scratch, actions[t])
        accumulate(state.trace, scratch.gradient, rules.gamma * rules.trace_decay)
        total += td_error * state.trace
        state.trace[:] *= not contact
    return from_online(total, *sizes_of(config))


@pytest.mark.parametrize(
    "changes",
    [
        {"epochs": 3, "optimiser": "radam"},
        {"minibatches": 3},
        {"shard_agents": 16, "max_gradient_norm": 0.01},
    ],
    ids=str,
)
def test_every_variant_learns_finite_weights(
    changes: dict[str, object], small_batched_config: TrainConfig
) -> None:
    learner = BatchedLearner(with_batched(small_batched_config, **changes))
    before = learner.weights
    learner.run(480)
    assert np.isfinite(learner.weights).all()
    assert not np.array_equal(learner.weights, before)


def test_averaged_weights_follow_the_last(small_batched_config: TrainConfig) -> None:
    learner = BatchedLearner(small_batched_config)
    average = learner.weights
    for _ in range(5):
        learner.run(160)
        average = 0.5 * average + 0.5 * learner.arrays()["weights"]
        np.testing.assert_allclose(learner.weights, average, atol=1e-6)


def test_batches_need_whole_shards() -> None:
    assert BatchedConfig(agents=48, shard_agents=16).batch_steps == 48 * 16
