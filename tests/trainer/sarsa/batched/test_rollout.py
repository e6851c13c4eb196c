"""Roll-outs: which actions are chosen, and what the world pays for them."""

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_trainer.config.train_config import ExplorationConfig, TrainConfig
from reflexarc_trainer.policy.weights import NetworkPolicy, network_of
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner, _seeds
from reflexarc_trainer.sarsa.batched.network_pass import forward_from_python
from reflexarc_trainer.sarsa.network_shape import Layers
from support.learning import with_batched


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
    average_reward = learner._learning.state.progress["average_reward"][0]
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


KEEPING = {
    "a least lead": ExplorationConfig(epsilon_start=0.0, epsilon_end=0.0, least_lead=0.02),
    "a margin": ExplorationConfig(epsilon_start=0.0, epsilon_end=0.0, margin=0.6),
}


@pytest.mark.parametrize("kind", KEEPING)
@pytest.mark.parametrize("target", ["sampled", "expected", "greedy"])
def test_an_action_is_kept_until_another_leads_by_enough_or_a_contact_ends_it(
    small_batched_config: TrainConfig, kind: str, target: Any
) -> None:
    """Against the rule in plain Python, agent by agent; and what each switch costs."""
    explore, cost = KEEPING[kind], -0.25
    learner_config = dataclasses.replace(
        small_batched_config.learner, exploration=explore, target=target, reward_switch=cost
    )
    config = dataclasses.replace(small_batched_config, learner=learner_config)
    learner = BatchedLearner(with_batched(config, precision="float64"))
    learner.run(160)
    kept = switched = freed = 0
    for _ in range(12):
        layers = learner._learning.layers
        weights = learner._learning.state.weights.copy()
        learner.run(160)
        rollout = learner._learning.rollout
        for shard, column in np.ndindex(rollout.actions.shape[0], rollout.actions.shape[2]):
            for t in range(1, rollout.actions.shape[1]):
                q = q_values_of(layers, weights, rollout.inputs[shard, t, :, column])
                before = int(rollout.actions[shard, t - 1, column])
                is_free = bool(rollout.contacts[shard, t - 1, column])
                least = max(explore.margin * (max(q) - min(q)), explore.least_lead)
                best = int(np.argmax(q))
                action = best if is_free or q[best] - q[before] >= least else before
                paid = cost if action != before and not is_free else 0.0
                place = shard, t, column
                assert rollout.actions[place] == action
                np.testing.assert_allclose(rollout.taken[place], q[action], rtol=1e-12)
                np.testing.assert_allclose(rollout.bootstraps[place], q[action] + paid, rtol=1e-12)
                kept += action != best
                switched += paid != 0.0
                freed += is_free and action != before
    assert min(kept, switched, freed) > 0


def q_values_of(layers: Layers, weights: npt.NDArray[Any], inputs: npt.NDArray[Any]) -> list[float]:
    """Of one state: (actions,)."""
    values = np.empty((layers.computed, 1))
    forward_from_python(layers, weights, inputs[:, np.newaxis].copy(), values)
    q_values: list[float] = values[-int(layers.sizes[-1]) :, 0].tolist()
    return q_values
