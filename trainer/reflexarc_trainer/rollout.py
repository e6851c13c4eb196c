"""A roll-out: all agents of a shard act, look and choose for T steps with the same weights.

The action that is chosen last, for the place where the roll-out ends, is the bootstrap of its
returns and the first one executed in the next roll-out. Everything is written by columns, an agent
each, into the shard's own rows: shards share nothing, so they run on any number of threads.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.kernel import Params, new_workspace, sense_agent, step_agent
from reflexarc_sim_bridge.params import Agents, EyeParams, WorldTables
from reflexarc_trainer.block import Block, Layers, forward
from reflexarc_trainer.choice import Streams, choose, expected_value
from reflexarc_trainer.fused import fused
from reflexarc_trainer.returns import lambda_returns


class Manner(NamedTuple):
    """How agents act and what it is worth: the same over a run."""

    motions: npt.NDArray[np.float64]
    """Linear, lateral and angular speed of each action: (actions, 3)."""
    curve: npt.NDArray[Any]
    """What the network sees of each byte: (256,)."""
    gamma: float
    trace_decay: float
    expected: bool
    terminal: bool
    reward_step: float
    reward_contact: float
    held_actions: int


class Pending(NamedTuple):
    """Where the agents stand between two roll-outs; a row or number an agent."""

    seen: npt.NDArray[np.uint8]
    """What they see: (agents, inputs)."""
    action: npt.NDArray[np.int64]
    """The action chosen for it."""
    held: npt.NDArray[np.int64]
    """Steps for which that action is still held after the next."""
    streams: Streams
    """Their exploration."""


class Rollout(NamedTuple):
    """What a roll-out brought; the first axis is the shard, the last its agents."""

    inputs: npt.NDArray[Any]
    """What was seen, as the network takes it: (shards, T + 1, inputs, columns)."""
    actions: npt.NDArray[np.int64]
    """What was chosen for it: (shards, T + 1, columns)."""
    taken: npt.NDArray[Any]
    """Q of that action; that of t = 0 is not filled: (shards, T + 1, columns)."""
    bootstraps: npt.NDArray[Any]
    """Value of the place: Q of the action, or its expectation; likewise."""
    rewards: npt.NDArray[Any]
    """(shards, T, columns)."""
    contacts: npt.NDArray[np.bool_]
    """(shards, T, columns)."""
    returns: npt.NDArray[Any]
    """λ-returns: (shards, T, columns)."""
    values: npt.NDArray[Any]
    """Scratch: the units of a block: (shards, computed, columns)."""


def new_rollout(
    shards: int, steps: int, columns: int, layers: Layers, dtype: npt.DTypeLike
) -> Rollout:
    """Room for a roll-out."""
    each, places = (shards, steps, columns), (shards, steps + 1, columns)
    return Rollout(
        inputs=np.zeros((shards, steps + 1, int(layers.sizes[0]), columns), dtype),
        actions=np.zeros(places, np.int64),
        taken=np.zeros(places, dtype),
        bootstraps=np.zeros(places, dtype),
        rewards=np.zeros(each, dtype),
        contacts=np.zeros(each, np.bool_),
        returns=np.zeros(each, dtype),
        values=np.zeros((shards, layers.computed, columns), dtype),
    )


@compiled_allocating
def roll_out(
    layers: Layers,
    weights: npt.NDArray[Any],
    manner: Manner,
    world: WorldTables,
    eye: EyeParams,
    agents: Agents,
    pending: Pending,
    rollout: Rollout,
    shard: int,
    epsilon: float,
    average_reward: float,
) -> None:
    """Fill the shard's rows of `rollout` from where its agents stand, and leave them behind it."""
    params = Params(world, eye, agents)
    work = new_workspace(params)
    steps, columns = rollout.rewards.shape[1], rollout.rewards.shape[2]
    first = shard * columns
    take_up(manner, pending, rollout, shard)
    for t in range(steps):
        actions, met = rollout.actions[shard, t], rollout.contacts[shard, t]
        # The world is called here and nowhere deeper: each level more compiles it once more.
        for c in range(columns):
            i, speeds = first + c, manner.motions[actions[c]]
            met[c] = step_agent(params, work, i, speeds[0], speeds[1], speeds[2])
            sense_agent(params, work, i)
            _see(manner.curve, agents.stack[i], pending.seen[i], rollout.inputs[shard, t + 1], c)
        _reward(manner, met, average_reward, rollout.rewards[shard, t])
        choose_all(layers, weights, manner, pending, rollout, shard, t + 1, met, epsilon)
    lambda_returns(
        rollout.rewards[shard],
        rollout.contacts[shard],
        rollout.taken[shard],
        rollout.bootstraps[shard],
        manner.gamma,
        manner.trace_decay,
        manner.terminal,
        rollout.returns[shard],
    )


@fused
def take_up(manner: Manner, pending: Pending, rollout: Rollout, shard: int) -> None:
    """Begin where the agents stand: with what they saw and chose last."""
    inputs, actions = rollout.inputs[shard, 0], rollout.actions[shard, 0]
    for c in range(len(actions)):
        i = shard * len(actions) + c
        seen = pending.seen[i]
        _see(manner.curve, seen, seen, inputs, c)
        actions[c] = pending.action[i]


@fused
def choose_all(
    layers: Layers,
    weights: npt.NDArray[Any],
    manner: Manner,
    pending: Pending,
    rollout: Rollout,
    shard: int,
    t: int,
    met: npt.NDArray[np.bool_],
    epsilon: float,
) -> None:
    """Choose an action for every agent of a shard at step t, and say what it is worth.

    ε-greedy, but for actions that are still held; a contact (`met`, (columns,)) ends the hold.
    """
    values, actions = rollout.values[shard], rollout.actions[shard, t]
    forward(layers, weights, rollout.inputs[shard, t], values)
    q_values = values[len(values) - layers.sizes[-1] :]
    for c in range(len(actions)):
        i = shard * len(actions) + c
        if pending.held[i] > 0 and not met[c]:
            pending.held[i] -= 1
        else:
            pending.held[i] = manner.held_actions - 1
            pending.action[i] = choose(q_values, c, epsilon, pending.streams, i)
        actions[c] = pending.action[i]
    taken, worth = rollout.taken[shard, t], rollout.bootstraps[shard, t]
    _value(manner.expected, q_values, actions, epsilon, taken, worth)


@fused
def _see(
    curve: npt.NDArray[Any],
    retina: npt.NDArray[np.uint8],
    seen: npt.NDArray[np.uint8],
    inputs: Block,
    column: int,
) -> None:
    """Keep a retina's bytes, and put them through the input curve into a column."""
    for i in range(len(retina)):
        value = retina[i]
        seen[i] = value
        inputs[i, column] = curve[value]


@fused
def _reward(
    manner: Manner,
    met: npt.NDArray[np.bool_],
    average_reward: float,
    rewards: npt.NDArray[Any],
) -> None:
    for c in range(len(rewards)):
        reward = manner.reward_contact if met[c] else manner.reward_step
        rewards[c] = reward - average_reward


@fused
def _value(
    expected: bool,
    q_values: Block,
    actions: npt.NDArray[np.int64],
    epsilon: float,
    taken: npt.NDArray[Any],
    bootstraps: npt.NDArray[Any],
) -> None:
    """What the chosen action is worth, and the place."""
    for c in range(len(actions)):
        q = q_values[actions[c], c]
        taken[c] = q
        bootstraps[c] = expected_value(q_values, c, epsilon) if expected else q
