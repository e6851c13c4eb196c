r"""SARSA(λ) over many agents at once: λ-returns, a gradient, an optimiser; compiled.

The second form of the algorithm in `reference.py`. An update is

    roll out      every shard of agents, T steps with the same weights       `rollout.py`
    return        G_t, backwards                                             `returns.py`
    gradient      of ½ mean (G_t − Q(s_t, a_t))², shard by shard             `block.py`
    descend       the sum over shards in their order, clipped, Adam          `optimiser.py`

and the last two as often as there are minibatches and epochs. A minibatch is every so many-th step
of every agent. Threads share out the shards and nothing else: the same bits on any number of them.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import compiled, fused, fused_free
from reflexarc_trainer.sarsa import schedules
from reflexarc_trainer.sarsa.batched.barrier import Gate, meet
from reflexarc_trainer.sarsa.batched.network_pass import backward, forward
from reflexarc_trainer.sarsa.batched.optimiser import Moments, clip_norm, descend
from reflexarc_trainer.sarsa.batched.rollout import Manner, Pending, Place, Rollout, roll_out
from reflexarc_trainer.sarsa.network_shape import Layers

linear = compiled(schedules.linear)


class Pace(NamedTuple):
    """The course of a run."""

    updates: float
    """Roll-outs of the whole run."""
    epochs: int
    minibatches: int
    learning_rate: float
    learning_rate_end: float
    """Share of it that is left at the end."""
    max_gradient_norm: float
    rectified: bool
    epsilon_start: float
    epsilon_end: float
    epsilon_updates: float
    """Roll-outs over which ε decays."""
    centring: float
    averaging: float


class Sums(NamedTuple):
    """The weights, and what moves them."""

    weights: npt.NDArray[Any]
    """(parameters,)"""
    averaged: npt.NDArray[Any]
    """Their average over the updates: (parameters,)."""
    back: npt.NDArray[Any]
    """Scratch: ∂L/∂ of a block's units: (shards, computed, columns)."""
    gradients: npt.NDArray[Any]
    """A row a shard: (shards, parameters)."""
    errors: npt.NDArray[np.float64]
    """Σ|G − Q| of each shard since the last report: (shards,)."""
    progress: npt.NDArray[np.float64]
    """Roll-outs done, average reward: (2,)."""


class Learning(NamedTuple):
    """Everything that an update reads and writes, but for the world."""

    layers: Layers
    manner: Manner
    pace: Pace
    pending: Pending
    rollout: Rollout
    sums: Sums
    moments: Moments


@fused_free
def learn(
    learning: Learning,
    place: Place,
    gate: Gate,
    threads: int,
    first: int,
    end: int,
    updates: int,
) -> None:
    """One thread's part of `updates` updates: all for the shards from `first` to `end`.

    The thread that has the first shard moves the weights, while the others wait.

    Args:
        learning: shared by all threads.
        place: this thread's.
        gate: where the threads meet.
        threads: how many there are.
        first: first shard.
        end: shard behind the last.
        updates: how often.
    """
    layers, manner, pace, pending, rollout, sums, moments = learning
    parts = pace.epochs * pace.minibatches
    for _ in range(updates):
        epsilon, average_reward = epsilon_now(pace, sums.progress), sums.progress[1]
        for shard in range(first, end):
            weights = sums.weights
            roll_out(
                layers, weights, manner, place, pending, rollout, shard, epsilon, average_reward
            )
        for part in range(parts):
            for shard in range(first, end):
                shard_gradient(layers, pace, rollout, sums, shard, part)
            meet(gate, threads)
            if first == 0:
                update_weights(pace, sums, moments, rollout.rewards.size)
                if part == parts - 1:
                    finish_update(manner, pace, sums, rollout.rewards)
            meet(gate, threads)


@fused
def epsilon_now(pace: Pace, progress: npt.NDArray[np.float64]) -> float:
    """Share of random actions in the next roll-out."""
    return linear(progress[0], pace.epsilon_start, pace.epsilon_end, pace.epsilon_updates)


@fused
def shard_gradient(
    layers: Layers, pace: Pace, rollout: Rollout, sums: Sums, shard: int, part: int
) -> None:
    """Gradient of ½ Σ (G − Q)² over a minibatch of a shard, into the shard's row.

    Args:
        layers: shape of the network.
        pace: says how many minibatches there are.
        rollout: with returns.
        sums: the weights, and where gradient and errors go.
        shard: which one.
        part: number of the minibatch, counted through all epochs.
    """
    gradient, back, values = sums.gradients[shard], sums.back[shard], rollout.values[shard]
    q_values = values[len(values) - layers.sizes[-1] :]
    down, total = back[len(values) - layers.sizes[-1] :], 0.0
    gradient[:] = 0
    for t in range(part % pace.minibatches, rollout.rewards.shape[1], pace.minibatches):
        inputs, returns = rollout.inputs[shard, t], rollout.returns[shard, t]
        forward(layers, sums.weights, inputs, values)
        down[:] = 0
        for c in range(len(returns)):
            action = rollout.actions[shard, t, c]
            error = q_values[action, c] - returns[c]
            down[action, c] = error
            total += abs(error)
        backward(layers, sums.weights, inputs, values, back, gradient)
    if part < pace.minibatches:
        sums.errors[shard] += total


@fused
def update_weights(pace: Pace, sums: Sums, moments: Moments, steps: int) -> None:
    """Sum the shards' gradients in their order, and move the weights.

    Args:
        pace: the course of the run.
        sums: the gradients, each a sum over its shard's part of a minibatch.
        moments: the optimiser's.
        steps: transitions of a roll-out, all agents together.
    """
    gradients, total = sums.gradients, sums.gradients[0]
    for shard in range(1, len(gradients)):
        for k in range(len(total)):
            total[k] += gradients[shard, k]
    share = total.dtype.type(pace.minibatches / steps)
    for k in range(len(total)):
        total[k] *= share
    clip_norm(total, pace.max_gradient_norm)
    end = pace.learning_rate * pace.learning_rate_end
    rate = linear(sums.progress[0], pace.learning_rate, end, pace.updates)
    descend(sums.weights, total, moments, rate, pace.rectified)


@fused
def finish_update(manner: Manner, pace: Pace, sums: Sums, rewards: npt.NDArray[Any]) -> None:
    """Count the roll-out and move the averages; `rewards` have the average one subtracted."""
    weights, averaged = sums.weights, sums.averaged
    keep = weights.dtype.type(pace.averaging)
    take = weights.dtype.type(1.0 - pace.averaging)
    for k in range(len(weights)):
        averaged[k] = keep * averaged[k] + take * weights[k]
    excess = 0.0
    for reward in rewards.flat:
        excess += reward / (rewards.size * manner.action_repeat)
    sums.progress[1] += pace.centring * excess
    sums.progress[0] += 1.0
