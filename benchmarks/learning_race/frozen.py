"""A frozen policy: a contender's weights at one moment, computed by the same NumPy code for all.

The greedy action is the one with the largest output; of equal ones the first, stay. A monotonic
activation function of the output units is left out, as it does not change the greedy action.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.learner_interface import Learner

Floats = npt.NDArray[np.float32]
Layer = tuple[Floats, Floats]
"""Weights (inputs, outputs) and biases (outputs,)."""


def relu(x: Floats) -> Floats:
    """max(x, 0)."""
    return np.maximum(x, np.float32(0))


def sigmoid(x: Floats) -> Floats:
    """1 / (1 + exp(−x))."""
    result: Floats = np.float32(1) / (np.float32(1) + np.exp(-x))
    return result


UNITS: dict[str, Callable[[Floats], Floats]] = {"relu": relu, "tanh": np.tanh, "sigmoid": sigmoid}


@dataclass(frozen=True)
class FrozenPolicy:
    """A network with fixed weights and its greedy policy."""

    layers: tuple[Layer, ...]
    units: str
    """Hidden units: one of UNITS."""
    input_power: int

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Outputs (n, actions), actions (n,) of retinas (n, frames, eyes, rays, channels)."""
        x = seen(retinas, self.input_power)
        for weights, biases in self.layers[:-1]:
            x = UNITS[self.units](x @ weights + biases)
        values = x @ self.layers[-1][0] + self.layers[-1][1]
        return values, np.argmax(values, axis=1)

    def equals(self, other: "FrozenPolicy") -> bool:
        """Whether all weights are equal."""
        pairs = zip(self.layers, other.layers, strict=True)
        return all(np.array_equal(a[k], b[k]) for a, b in pairs for k in (0, 1))


def seen(retinas: RetinaBatch, input_power: int) -> Floats:
    """Inputs of a network: (byte / 255) to the input power, (n, inputs)."""
    curve = ((np.arange(FULL_SCALE + 1) / FULL_SCALE) ** input_power).astype(np.float32)
    result: Floats = curve[retinas.reshape(len(retinas), -1)]
    return result


def of_ours(learner: Learner) -> FrozenPolicy:
    """The policy that one of our learners would export now."""
    config = learner.config
    layers = _split(learner.weights.astype(np.float32), layer_sizes(config))
    return FrozenPolicy(layers, config.network.units, config.network.input_power)


def layer_sizes(config: TrainConfig) -> list[int]:
    """Numbers of inputs, of units in each hidden layer, and of actions."""
    contract = config.contract()
    return [contract.retina.size, *config.network.hidden, len(contract.actions)]


def of_theirs(model: Any, input_power: int) -> FrozenPolicy:
    """The greedy policy of a model of Stable-Baselines3 or sb3-contrib."""
    policy = model.policy
    if hasattr(policy, "action_net"):
        parts = [*policy.mlp_extractor.policy_net, policy.action_net]
    elif hasattr(policy, "q_net"):
        parts = [*policy.q_net.q_net]
    else:
        parts = [*policy.quantile_net.quantile_net]
    layers = [_layer(part) for part in parts if hasattr(part, "weight")]
    if hasattr(policy, "quantile_net"):
        layers[-1] = _mean_of_quantiles(layers[-1], policy.quantile_net.n_quantiles)
    units = next(part for part in parts if not hasattr(part, "weight"))
    return FrozenPolicy(tuple(layers), type(units).__name__.lower(), input_power)


def _layer(part: Any) -> Layer:
    return part.weight.detach().numpy().T.copy(), part.bias.detach().numpy().copy()


def _mean_of_quantiles(layer: Layer, quantiles: int) -> Layer:
    """A layer whose outputs are the means of the quantiles; as it is linear, of their weights."""
    weights, biases = layer
    mean = weights.reshape(len(weights), quantiles, -1).mean(axis=1)
    return mean, biases.reshape(quantiles, -1).mean(axis=0)


def _split(weights: Floats, sizes: Sequence[int]) -> tuple[Layer, ...]:
    """The layers of a vector of weights in torch's order."""
    layers, at = [], 0
    for n_in, n_out in pairwise(sizes):
        matrix = weights[at : at + n_in * n_out].reshape(n_out, n_in)
        at += n_in * n_out
        layers.append((matrix.T.copy(), weights[at : at + n_out].copy()))
        at += n_out
    return tuple(layers)
