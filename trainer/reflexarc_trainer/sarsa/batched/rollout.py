"""A roll-out: all agents of a shard act, look and choose for T steps with the same weights.

The action that is chosen last, for the place where the roll-out ends, is the bootstrap of its
returns and the first one executed in the next roll-out. Everything is written by columns, an agent
each, into the shard's own rows: shards share nothing, so they run on any number of threads.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_trainer.sarsa.batched.network_pass import Block, forward
from reflexarc_trainer.sarsa.batched.returns import lambda_returns
from reflexarc_trainer.sarsa.exploration import Streams, choose, expected_value, winner
from reflexarc_trainer.sarsa.network_shape import Layers

NOT_CHOSEN = -1
"""In the place of how long an action is still held."""


class Place(NamedTuple):
    """The world as one thread calls it."""

    step: FunctionPointer
    """`simulation.step.advance`."""
    held: Struct
    """A `simulation.step_pointer.Held`."""
    stack: npt.NDArray[np.uint8]
    """What the agents see: (agents, inputs)."""


class Manner(NamedTuple):
    """How agents choose and what it is worth: the same over a run."""

    curve: npt.NDArray[Any]
    """What the network sees of each byte: (256,)."""
    gamma: float
    trace_decay: float
    expected: bool
    greedy: bool
    terminal: bool
    reward_step: float
    reward_contact: float
    held_actions: int
    action_repeat: int
    """Steps of the world an action."""


class Pending(NamedTuple):
    """Where the agents stand between two roll-outs; a row or number an agent."""

    seen: npt.NDArray[np.uint8]
    """What they see: (agents, inputs)."""
    action: npt.NDArray[np.int64]
    """The action chosen for it."""
    held: npt.NDArray[np.int64]
    """Steps for which that action is still held after the next; NOT_CHOSEN where there is none."""
    met: npt.NDArray[np.bool_]
    """Whether the last step ended in a contact."""
    streams: Streams
    """Their exploration."""


class Rollout(NamedTuple):
    """What a roll-out brought; the first axis is the shard, the last its agents."""

    inputs: npt.NDArray[Any]
    """What was seen, as the network takes it: (shards, T + 1, inputs, columns)."""
    actions: npt.NDArray[np.int64]
    """What was chosen for it: (shards, T + 1, columns)."""
    taken: npt.NDArray[Any]
    """Q of that action; that of t = 0 is not used: (shards, T + 1, columns)."""
    bootstraps: npt.NDArray[Any]
    """Value of the place: Q of the action, or its expectation; likewise."""
    rewards: npt.NDArray[Any]
    """What each action brought, its repetitions added up: (shards, T, columns)."""
    contacts: npt.NDArray[np.bool_]
    """Whether it met an obstacle meanwhile: (shards, T, columns)."""
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


@fused
def roll_out(
    layers: Layers,
    weights: npt.NDArray[Any],
    manner: Manner,
    place: Place,
    pending: Pending,
    rollout: Rollout,
    shard: int,
    epsilon: float,
    average_reward: float,
) -> None:
    """Fill the shard's rows of `rollout` from where its agents stand, and leave them behind it.

    In a new world they choose their first actions before.
    """
    steps, columns = rollout.rewards.shape[1], rollout.rewards.shape[2]
    first, end = shard * columns, (shard + 1) * columns
    _stand(layers, weights, manner, pending, rollout, shard, epsilon)
    for t in range(steps):
        contacts, rewards = rollout.contacts[shard, t], rollout.rewards[shard, t]
        contacts[:], rewards[:] = False, 0
        for repeated in range(1, manner.action_repeat + 1):
            tasks = MOVE + LOOK if repeated == manner.action_repeat else MOVE
            step_world(place.step, place.held, pending.action, pending.met, tasks, first, end)
            _reap(manner, pending.met[first:end], average_reward, contacts, rewards)
        for c in range(columns):
            _see(manner.curve, place.stack[first + c], rollout.inputs[shard, t + 1], c)
        choose_all(layers, weights, manner, pending, rollout, shard, t + 1, epsilon)
    for i in range(first, end):
        _keep(place.stack[i], pending.seen[i])
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
def _stand(
    layers: Layers,
    weights: npt.NDArray[Any],
    manner: Manner,
    pending: Pending,
    rollout: Rollout,
    shard: int,
    epsilon: float,
) -> None:
    """Fill in what the agents see at t = 0 and what they have chosen for it, or choose it now."""
    actions = rollout.actions[shard, 0]
    first = shard * len(actions)
    for c in range(len(actions)):
        _see(manner.curve, pending.seen[first + c], rollout.inputs[shard, 0], c)
        actions[c] = pending.action[first + c]
    if pending.held[first] == NOT_CHOSEN:
        choose_all(layers, weights, manner, pending, rollout, shard, 0, epsilon)


@fused
def choose_all(
    layers: Layers,
    weights: npt.NDArray[Any],
    manner: Manner,
    pending: Pending,
    rollout: Rollout,
    shard: int,
    t: int,
    epsilon: float,
) -> None:
    """Choose an action for every agent of a shard at step t, and say what it is worth.

    ε-greedy, but for actions that are still held; a contact ends the hold.
    """
    values, actions = rollout.values[shard], rollout.actions[shard, t]
    forward(layers, weights, rollout.inputs[shard, t], values)
    q_values = values[len(values) - layers.sizes[-1] :]
    for c in range(len(actions)):
        i = shard * len(actions) + c
        if pending.held[i] > 0 and not pending.met[i]:
            pending.held[i] -= 1
        else:
            pending.held[i] = manner.held_actions - 1
            pending.action[i] = choose(q_values, c, epsilon, pending.streams, i)
        actions[c] = pending.action[i]
    taken, worth = rollout.taken[shard, t], rollout.bootstraps[shard, t]
    _value(manner, q_values, actions, epsilon, taken, worth)


@fused
def _see(
    curve: npt.NDArray[Any],
    retina: npt.NDArray[np.uint8],
    inputs: Block,
    column: int,
) -> None:
    """Put a retina's bytes through the input curve into a column."""
    for i in range(len(retina)):
        inputs[i, column] = curve[retina[i]]


@fused
def _keep(retina: npt.NDArray[np.uint8], seen: npt.NDArray[np.uint8]) -> None:
    for k in range(len(retina)):
        seen[k] = retina[k]


@fused
def _reap(
    manner: Manner,
    met: npt.NDArray[np.bool_],
    average_reward: float,
    contacts: npt.NDArray[np.bool_],
    rewards: npt.NDArray[Any],
) -> None:
    """Add what a step of the world brought to what the action has brought so far."""
    for c in range(len(rewards)):
        reward = manner.reward_contact if met[c] else manner.reward_step
        rewards[c] += reward - average_reward
        contacts[c] |= met[c]


@fused
def _value(
    manner: Manner,
    q_values: Block,
    actions: npt.NDArray[np.int64],
    epsilon: float,
    taken: npt.NDArray[Any],
    bootstraps: npt.NDArray[Any],
) -> None:
    """What the chosen action is worth, and the place; both are the best action's where greedy."""
    for c in range(len(actions)):
        q = q_values[actions[c], c]
        taken[c] = q
        bootstraps[c] = expected_value(q_values, c, epsilon) if manner.expected else q
        if manner.greedy:
            taken[c] = bootstraps[c] = q_values[winner(q_values, c), c]
