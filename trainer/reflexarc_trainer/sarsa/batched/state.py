"""Memory of the batched learner: a run's constants, what changes, and the record of a roll-out.

Compiled code is given these tuples of numbers and arrays. Agents are divided into shards of equal
size, each computed by one thread; columns of an array are the agents of a shard.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.function_pointers import FunctionPointer
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched.optimiser import Moments, new_moments
from reflexarc_trainer.sarsa.exploration import Streams, new_streams
from reflexarc_trainer.sarsa.initial_weights import initial_weights
from reflexarc_trainer.sarsa.network_shape import Layers, input_curve, layers_for

NOT_CHOSEN = -1
"""Value of `AgentStates.held_actions` while no action is chosen."""

PROGRESS_DTYPE = np.dtype(
    # Updates (roll-outs) so far; the running average of the reward per world step.
    [("updates", np.int64), ("average_reward", np.float64)],
    align=True,
)
"""The single numbers that change from update to update."""


class RolloutRules(NamedTuple):
    """The constants of a run's roll-outs; the configuration documents those without a docstring."""

    curve: npt.NDArray[Any]
    """What the network sees of each byte: (256,)."""
    gamma: float
    trace_decay: float
    expected: bool
    """Whether the target takes the expectation over a′ in place of Q(s′, a′)."""
    greedy: bool
    """Whether it takes the largest Q(s′, ·)."""
    terminal: bool
    """Whether the value of s′ counts as 0 after a contact."""
    reward_step: float
    reward_contact: float
    held_actions: int
    action_repeat: int
    """World steps per transition."""
    margin: float
    least_lead: float
    reward_switch: float


class UpdateRules(NamedTuple):
    """The constants of a run's updates; the configuration documents those without a docstring."""

    updates: float
    """Updates (roll-outs) of the whole run."""
    epochs: int
    minibatches: int
    learning_rate: float
    learning_rate_end: float
    """Share of the learning rate that is left at the end of the run."""
    max_gradient_norm: float
    rectified: bool
    """RAdam; else Adam."""
    epsilon_start: float
    epsilon_end: float
    epsilon_updates: float
    """Updates over which ε decays."""
    centring: float
    """`learner.reward_centring`."""
    averaging: float
    """`learner.averaged_weights`."""


class WorldAccess(NamedTuple):
    """How one thread reaches the world."""

    step: FunctionPointer
    """The compiled function `simulation.step.advance`."""
    held: Struct
    """What it works on: a `simulation.step_pointer.Held`."""
    stack: npt.NDArray[np.uint8]
    """Memory where the world puts what the agents see: (agents, inputs)."""


class AgentStates(NamedTuple):
    """What the agents carry from one roll-out to the next."""

    seen: npt.NDArray[np.uint8]
    """What they see: (agents, inputs)."""
    action: npt.NDArray[np.int64]
    """The action chosen for it: (agents,)."""
    held_actions: npt.NDArray[np.int64]
    """Further transitions for which that action is held, or NOT_CHOSEN: (agents,)."""
    met: npt.NDArray[np.bool_]
    """Whether the last world step ended in a contact: (agents,)."""
    streams: Streams
    """Random streams of their exploration: (agents,)."""


class Rollout(NamedTuple):
    """The record of a roll-out; the first axis is the shard, the last the shard's agents."""

    inputs: npt.NDArray[Any]
    """What the network saw of state t: (shards, T + 1, inputs, columns)."""
    actions: npt.NDArray[np.int64]
    """a_t, chosen there: (shards, T + 1, columns)."""
    taken: npt.NDArray[Any]
    """Q_t = Q(s_t, a_t); that of t = 0 is not used: (shards, T + 1, columns)."""
    bootstraps: npt.NDArray[Any]
    """V_t, the value of state t as a target takes it: (shards, T + 1, columns)."""
    rewards: npt.NDArray[Any]
    """r_t, the sum over repetitions, less the average reward: (shards, T, columns)."""
    contacts: npt.NDArray[np.bool_]
    """Whether the agent met an obstacle in transition t: (shards, T, columns)."""
    returns: npt.NDArray[Any]
    """G_t, the λ-returns: (shards, T, columns)."""
    values: npt.NDArray[Any]
    """Scratch: the activations of a forward pass: (shards, computed, columns)."""


class WeightState(NamedTuple):
    """The weights, their gradients, and what a report says of the updates."""

    weights: npt.NDArray[Any]
    """w, in the order of `policy/weights.py`: (parameters,)."""
    averaged: npt.NDArray[Any]
    """Average of w over the updates: (parameters,)."""
    back: npt.NDArray[Any]
    """Scratch: ∂L / ∂(each unit) of a backward pass: (shards, computed, columns)."""
    gradients: npt.NDArray[Any]
    """∂L/∂w of each shard: (shards, parameters)."""
    errors: npt.NDArray[np.float64]
    """Σ|G − Q| of each shard since the last report: (shards,)."""
    progress: npt.NDArray[np.void]
    """`PROGRESS_DTYPE`: (1,)."""


class Learning(NamedTuple):
    """Everything that an update reads and writes, except the world."""

    layers: Layers
    rollout_rules: RolloutRules
    update_rules: UpdateRules
    agents: AgentStates
    rollout: Rollout
    state: WeightState
    moments: Moments


def new_learning(config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> Learning:
    """Everything that an update reads and writes, before the first one.

    Args:
        config: the run.
        weights: initial weights; by default those that the seed gives: (parameters,).
    """
    batched, contract = config.learner.batched, config.contract()
    shards, columns = batched.agents // batched.shard_agents, batched.shard_agents
    layers, dtype = layers_for(config.network, contract), np.dtype(batched.precision)
    weights = initial_weights(config) if weights is None else weights
    weights = weights.astype(dtype)
    return Learning(
        layers=layers,
        rollout_rules=_rollout_rules_for(config),
        update_rules=update_rules_for(config),
        agents=AgentStates(
            seen=np.zeros((batched.agents, int(layers.sizes[0])), np.uint8),
            action=np.zeros(batched.agents, np.int64),
            held_actions=np.full(batched.agents, NOT_CHOSEN),
            met=np.zeros(batched.agents, np.bool_),
            streams=new_streams(config.seed, batched.agents),
        ),
        rollout=new_rollout(shards, batched.rollout_steps, columns, layers, dtype),
        state=WeightState(
            weights=weights,
            averaged=weights.copy(),
            back=np.zeros((shards, layers.computed, columns), dtype),
            gradients=np.zeros((shards, len(weights)), dtype),
            errors=np.zeros(shards),
            progress=np.zeros(1, PROGRESS_DTYPE),
        ),
        moments=new_moments(len(weights), dtype),
    )


def update_rules_for(config: TrainConfig) -> UpdateRules:
    """The constants of a run's updates."""
    learner, batched, explore = config.learner, config.learner.batched, config.learner.exploration
    updates = config.steps / batched.batch_steps
    return UpdateRules(
        updates=updates,
        epochs=batched.epochs,
        minibatches=batched.minibatches,
        learning_rate=batched.learning_rate,
        learning_rate_end=batched.learning_rate_end,
        max_gradient_norm=batched.max_gradient_norm,
        rectified=batched.optimiser == "radam",
        epsilon_start=explore.epsilon_start,
        epsilon_end=explore.epsilon_end,
        epsilon_updates=explore.epsilon_span * updates,
        centring=learner.reward_centring,
        averaging=learner.averaged_weights,
    )


def _rollout_rules_for(config: TrainConfig) -> RolloutRules:
    learner = config.learner
    return RolloutRules(
        curve=input_curve(config.network, learner.batched.precision),
        gamma=learner.gamma,
        trace_decay=learner.trace_decay,
        expected=learner.target == "expected",
        greedy=learner.target == "greedy",
        terminal=learner.after_contact == "terminal",
        reward_step=learner.reward_step,
        reward_contact=learner.reward_contact,
        held_actions=learner.exploration.held_actions,
        action_repeat=learner.exploration.action_repeat,
        margin=learner.exploration.margin,
        least_lead=learner.exploration.least_lead,
        reward_switch=learner.reward_switch,
    )


def new_rollout(
    shards: int, steps: int, columns: int, layers: Layers, dtype: npt.DTypeLike
) -> Rollout:
    """Memory for a roll-out of so many transitions."""
    each, states = (shards, steps, columns), (shards, steps + 1, columns)
    return Rollout(
        inputs=np.zeros((shards, steps + 1, int(layers.sizes[0]), columns), dtype),
        actions=np.zeros(states, np.int64),
        taken=np.zeros(states, dtype),
        bootstraps=np.zeros(states, dtype),
        rewards=np.zeros(each, dtype),
        contacts=np.zeros(each, np.bool_),
        returns=np.zeros(each, dtype),
        values=np.zeros((shards, layers.computed, columns), dtype),
    )
