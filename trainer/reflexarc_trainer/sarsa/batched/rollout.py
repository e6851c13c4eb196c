"""A roll-out: all agents of a shard act, sense and choose for T transitions with the same weights.

The action that is chosen last, for the state in which the roll-out ends, gives the bootstrap value
of its returns and is the first action of the next roll-out. Arrays have one column per agent. Each
shard writes into rows of its own only, so that shards can run on any number of threads.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_trainer.sarsa.batched.network_pass import Block, forward
from reflexarc_trainer.sarsa.batched.returns import lambda_returns
from reflexarc_trainer.sarsa.batched.state import (
    NOT_CHOSEN,
    AgentStates,
    Rollout,
    RolloutRules,
    WorldAccess,
)
from reflexarc_trainer.sarsa.exploration import FREE, choose, expected_value, greedy
from reflexarc_trainer.sarsa.network_shape import Layers


@fused
def roll_out(
    layers: Layers,
    weights: npt.NDArray[Any],
    rules: RolloutRules,
    world: WorldAccess,
    agents: AgentStates,
    rollout: Rollout,
    shard: int,
    epsilon: float,
    average_reward: float,
) -> None:
    """Fill a shard's rows of `rollout`, and move its agents to the end of the roll-out.

    Args:
        layers: shape of the network.
        weights: (parameters,).
        rules: the constants of the run.
        world: where the agents are.
        agents: where the roll-out begins; those in a new world choose their first action.
        rollout: filled.
        shard: number of the shard.
        epsilon: ε.
        average_reward: subtracted from the reward of every world step.
    """
    _, steps, columns = rollout.rewards.shape
    first = shard * columns
    _begin(layers, weights, rules, agents, rollout, shard, epsilon)
    for t in range(steps):
        _act(rules, world, agents, rollout, shard, t, average_reward)
        choose_all(layers, weights, rules, agents, rollout, shard, t + 1, epsilon)
    for i in range(first, first + columns):
        _copy(world.stack[i], agents.seen[i])
    lambda_returns(
        rollout.rewards[shard],
        rollout.contacts[shard],
        rollout.taken[shard],
        rollout.bootstraps[shard],
        rules.gamma,
        rules.trace_decay,
        rules.terminal,
        rollout.returns[shard],
    )


@fused
def choose_all(
    layers: Layers,
    weights: npt.NDArray[Any],
    rules: RolloutRules,
    agents: AgentStates,
    rollout: Rollout,
    shard: int,
    t: int,
    epsilon: float,
) -> None:
    """Choose the action a_t of every agent of a shard, and fill in its values Q_t and V_t.

    The choice is ε-greedy, but for actions that are still held; a contact ends the hold, and then
    no action is in force.
    """
    values, actions = rollout.values[shard], rollout.actions[shard, t]
    forward(layers, weights, rollout.inputs[shard, t], values)
    q_values = values[len(values) - layers.sizes[-1] :]
    taken, bootstraps = rollout.taken[shard, t], rollout.bootstraps[shard, t]
    margin, least_lead, streams = rules.margin, rules.least_lead, agents.streams
    for c in range(len(actions)):
        i = shard * len(actions) + c
        is_free = agents.met[i] or agents.held_actions[i] == NOT_CHOSEN
        in_force = FREE if is_free else agents.action[i]
        if agents.held_actions[i] > 0 and not agents.met[i]:
            agents.held_actions[i] -= 1
        else:
            agents.held_actions[i] = rules.held_actions - 1
            agents.action[i] = choose(
                q_values, c, epsilon, streams, i, in_force, margin, least_lead
            )
        actions[c] = agents.action[i]
        _fill_values(rules, q_values, c, actions[c], in_force, epsilon, taken, bootstraps)


@fused
def _begin(
    layers: Layers,
    weights: npt.NDArray[Any],
    rules: RolloutRules,
    agents: AgentStates,
    rollout: Rollout,
    shard: int,
    epsilon: float,
) -> None:
    """Fill in state and action of t = 0; where no action is chosen yet, choose it."""
    actions = rollout.actions[shard, 0]
    first = shard * len(actions)
    for c in range(len(actions)):
        _encode(rules.curve, agents.seen[first + c], rollout.inputs[shard, 0], c)
        actions[c] = agents.action[first + c]
    if agents.held_actions[first] == NOT_CHOSEN:
        choose_all(layers, weights, rules, agents, rollout, shard, 0, epsilon)


@fused
def _act(
    rules: RolloutRules,
    world: WorldAccess,
    agents: AgentStates,
    rollout: Rollout,
    shard: int,
    t: int,
    average_reward: float,
) -> None:
    """Do the actions a_t; fill in their rewards and contacts, and the inputs of s_{t+1}."""
    contacts, rewards = rollout.contacts[shard, t], rollout.rewards[shard, t]
    first, end = shard * len(rewards), (shard + 1) * len(rewards)
    contacts[:], rewards[:] = False, 0
    for repeated in range(1, rules.action_repeat + 1):
        tasks = MOVE + LOOK if repeated == rules.action_repeat else MOVE
        step_world(world.step, world.held, agents.action, agents.met, tasks, first, end)
        _add_rewards(rules, agents.met[first:end], average_reward, contacts, rewards)
    for c in range(len(rewards)):
        _encode(rules.curve, world.stack[first + c], rollout.inputs[shard, t + 1], c)


@fused
def _encode(
    curve: npt.NDArray[Any],
    retina: npt.NDArray[np.uint8],
    inputs: Block,
    column: int,
) -> None:
    """Fill a column of inputs from a retina's bytes, by the input curve."""
    for i in range(len(retina)):
        inputs[i, column] = curve[retina[i]]


@fused
def _copy(retina: npt.NDArray[np.uint8], seen: npt.NDArray[np.uint8]) -> None:
    for k in range(len(retina)):
        seen[k] = retina[k]


@fused
def _add_rewards(
    rules: RolloutRules,
    met: npt.NDArray[np.bool_],
    average_reward: float,
    contacts: npt.NDArray[np.bool_],
    rewards: npt.NDArray[Any],
) -> None:
    """Add the rewards and contacts of a world step to those of its transition: (columns,) each."""
    for c in range(len(rewards)):
        reward = rules.reward_contact if met[c] else rules.reward_step
        rewards[c] += reward - average_reward
        contacts[c] |= met[c]


@fused
def _fill_values(
    rules: RolloutRules,
    q_values: Block,
    c: int,
    action: int,
    in_force: int,
    epsilon: float,
    taken: npt.NDArray[Any],
    bootstraps: npt.NDArray[Any],
) -> None:
    """Fill an agent's Q_t and V_t (columns,); with Q(λ), both are the greedy action's value.

    What a switch costs is paid before s_t, so it belongs to V_t and not to Q_t.
    """
    taken[c] = bootstraps[c] = q_values[action, c]
    if rules.expected or rules.greedy:
        best = greedy(q_values, c, in_force, rules.margin, rules.least_lead)
        if rules.greedy:
            taken[c] = bootstraps[c] = q_values[best, c]
        else:
            bootstraps[c] = expected_value(q_values, c, epsilon, best)
    if rules.reward_switch != 0.0 and in_force not in (FREE, action):
        bootstraps[c] += rules.reward_switch
