r"""Batched SARSA(λ): many agents, λ-returns, a gradient and an optimiser; compiled.

The second form of the algorithm in `reference.py`; it is built like PQN (arXiv 2407.04811), with
the value of the chosen action in place of the largest one. An update is

    roll out      every shard of agents, T transitions with the same weights   `rollout.py`
    returns       G_t, backwards from the end                                  `returns.py`
    gradient      of ½ mean (G_t − Q(s_t, a_t))², shard by shard               `network_pass.py`
    descend       the sum over shards in their order, clipped, Adam            `optimiser.py`

The last two are done once per minibatch and epoch; a minibatch is every n-th transition of every
agent. Each thread computes shards of its own, and sums over shards have a fixed order, so that the
bits do not depend on the number of threads.
"""

from typing import Any

import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import compiled, fused, fused_free
from reflexarc_trainer.sarsa import schedules
from reflexarc_trainer.sarsa.batched.barrier import Barrier, wait_for_all
from reflexarc_trainer.sarsa.batched.network_pass import backward, forward
from reflexarc_trainer.sarsa.batched.optimiser import Moments, clip_norm, descend
from reflexarc_trainer.sarsa.batched.rollout import roll_out
from reflexarc_trainer.sarsa.batched.state import (
    Learning,
    Rollout,
    RolloutRules,
    UpdateRules,
    WeightState,
    WorldAccess,
)
from reflexarc_trainer.sarsa.network_shape import Layers

linear = compiled(schedules.linear)


@fused_free
def learn(
    learning: Learning,
    world: WorldAccess,
    barrier: Barrier,
    threads: int,
    first: int,
    end: int,
    updates: int,
) -> None:
    """Do one thread's part of a number of updates: the shards from `first` to before `end`.

    The thread that has the first shard moves the weights, while the others wait.

    Args:
        learning: shared by all threads.
        world: this thread's access to the world.
        barrier: shared by all threads.
        threads: how many there are.
        first: number of the first shard.
        end: number of the last shard, plus 1.
        updates: how many.
    """
    layers, rollout_rules, rules, agents, rollout, state, moments = learning
    parts = rules.epochs * rules.minibatches
    for _ in range(updates):
        epsilon, reward = epsilon_now(rules, state), state.progress[0].average_reward
        for shard in range(first, end):
            weights = state.weights
            roll_out(layers, weights, rollout_rules, world, agents, rollout, shard, epsilon, reward)
        for part in range(parts):
            for shard in range(first, end):
                shard_gradient(layers, rules, rollout, state, shard, part)
            wait_for_all(barrier, threads)
            if first == 0:
                move_weights(rules, state, moments, rollout.rewards.size)
                if part == parts - 1:
                    finish_update(rollout_rules, rules, state, rollout.rewards)
            wait_for_all(barrier, threads)


@fused
def epsilon_now(rules: UpdateRules, state: WeightState) -> float:
    """The exploration rate ε of the next roll-out."""
    updates = state.progress[0].updates
    return linear(updates, rules.epsilon_start, rules.epsilon_end, rules.epsilon_updates)


@fused
def shard_gradient(
    layers: Layers,
    rules: UpdateRules,
    rollout: Rollout,
    state: WeightState,
    shard: int,
    part: int,
) -> None:
    """Compute the gradient of ½ Σ (G − Q)² over a shard's part of a minibatch.

    Args:
        layers: shape of the network.
        rules: give the number of minibatches.
        rollout: with its returns.
        state: the weights; the shard's gradient is filled, its errors are added to.
        shard: number of the shard.
        part: number of the minibatch, counted through all epochs.
    """
    gradient, back, values = state.gradients[shard], state.back[shard], rollout.values[shard]
    q_values = values[len(values) - layers.sizes[-1] :]
    q_back, total = back[len(values) - layers.sizes[-1] :], 0.0
    gradient[:] = 0
    for t in range(part % rules.minibatches, rollout.rewards.shape[1], rules.minibatches):
        inputs, returns = rollout.inputs[shard, t], rollout.returns[shard, t]
        forward(layers, state.weights, inputs, values)
        q_back[:] = 0
        for c in range(len(returns)):
            action = rollout.actions[shard, t, c]
            error = q_values[action, c] - returns[c]
            q_back[action, c] = error
            total += abs(error)
        backward(layers, state.weights, inputs, values, back, gradient)
    if part < rules.minibatches:
        state.errors[shard] += total


@fused
def move_weights(rules: UpdateRules, state: WeightState, moments: Moments, steps: int) -> None:
    """Sum the shards' gradients in their order, and update the weights.

    Args:
        rules: the constants of the run.
        state: the weights, and each shard's gradient, a sum over its transitions.
        moments: the optimiser's.
        steps: transitions of a roll-out, all agents together.
    """
    gradients, total = state.gradients, state.gradients[0]
    for shard in range(1, len(gradients)):
        for k in range(len(total)):
            total[k] += gradients[shard, k]
    share = total.dtype.type(rules.minibatches / steps)
    for k in range(len(total)):
        total[k] *= share
    clip_norm(total, rules.max_gradient_norm)
    end = rules.learning_rate * rules.learning_rate_end
    rate = linear(state.progress[0].updates, rules.learning_rate, end, rules.updates)
    descend(state.weights, total, moments, rate, rules.rectified)


@fused
def finish_update(
    rollout_rules: RolloutRules,
    rules: UpdateRules,
    state: WeightState,
    rewards: npt.NDArray[Any],
) -> None:
    """Count the update; move the averages of weights and reward.

    Args:
        rollout_rules: give the number of world steps per transition.
        rules: the constants of the run.
        state: the weights and their average.
        rewards: of the roll-out, less the average reward: (shards, T, columns).
    """
    weights, averaged, progress = state.weights, state.averaged, state.progress[0]
    keep = weights.dtype.type(rules.averaging)
    take = weights.dtype.type(1.0 - rules.averaging)
    for k in range(len(weights)):
        averaged[k] = keep * averaged[k] + take * weights[k]
    excess = 0.0
    for reward in rewards.flat:
        excess += reward / (rewards.size * rollout_rules.action_repeat)
    progress.average_reward += rules.centring * excess
    progress.updates += 1
