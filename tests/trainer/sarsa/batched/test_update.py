"""The gradient of a roll-out equals the online learner's sum of TD errors times traces."""

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched import network_pass as batched_pass
from reflexarc_trainer.sarsa.batched import returns, update
from reflexarc_trainer.sarsa.batched.state import (
    PROGRESS_DTYPE,
    Rollout,
    WeightState,
    new_rollout,
    update_rules_for,
)
from reflexarc_trainer.sarsa.network_shape import Layers, layers_for
from reflexarc_trainer.sarsa.online import network_pass as online_pass
from reflexarc_trainer.sarsa.online import traces
from reflexarc_trainer.sarsa.online.learner import new_learning, rules_for, sizes_of
from reflexarc_trainer.sarsa.online.weight_rows import from_online, to_online
from support.compiled_calls import from_python
from support.learning import with_batched
from support.precision import in_double

batch_forward = from_python(batched_pass.forward)
shard_gradient = from_python(update.shard_gradient)
fill_gradient = from_python(online_pass.fill_gradient)
forward = from_python(online_pass.forward)
lambda_returns = from_python(returns.lambda_returns)
accumulate = from_python(traces.accumulate)


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
    state = WeightState(
        weights=weights,
        averaged=weights.copy(),
        back=np.zeros((1, layers.computed, 1)),
        gradients=np.zeros((1, layers.parameters)),
        errors=np.zeros(1),
        progress=np.zeros(1, PROGRESS_DTYPE),
    )
    shard_gradient(layers, update_rules_for(config), rollout, state, 0, 0)
    total = online_sum(config, weights, rollout)
    np.testing.assert_allclose(-state.gradients[0], total, rtol=0, atol=1e-10)


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
