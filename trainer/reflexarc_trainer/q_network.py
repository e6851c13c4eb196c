"""The network: retina → sigmoid hidden units → one value an action (paper: 16–10–3).

Q(s, ·) = W₂ σ(W₁ x + b₁) + b₂ with x in [0, 1], or σ of it where the output units are sigmoid.
"""

import math

import numpy as np
import torch
from torch import Tensor, nn

from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.retina import FULL_SCALE
from reflexarc_trainer.config import LearnerConfig


def intensity(retinas: Tensor) -> Tensor:
    """Retinas as floats in [0, 1]: bytes become float64 / 255, floats are taken as they are."""
    return retinas if retinas.is_floating_point() else retinas.double() / FULL_SCALE


# The exporter translates a module by tracing it; this call stays one node, which it knows.
torch.fx.wrap("intensity")


class QNetwork(nn.Module):
    """Action values of retinas.

    Args:
        inputs: values of a retina stack.
        actions: number of actions.
        learner: hidden units, output units and initial weights.
    """

    def __init__(self, inputs: int, actions: int, learner: LearnerConfig) -> None:
        super().__init__()
        self.flatten = nn.Flatten()
        self.hidden = nn.Linear(inputs, learner.hidden)
        self.hidden_units = nn.Sigmoid()
        self.output = nn.Linear(learner.hidden, actions)
        self.output_units = nn.Sigmoid() if learner.output == "sigmoid" else nn.Identity()

    def forward(self, retinas: Tensor) -> Tensor:
        """Q-values (n, actions) of retinas (n, frames, eyes, rays, channels).

        Args:
            retinas: uint8 (then the weights must be float64), or floats in [0, 1].
        """
        x = self.flatten(intensity(retinas))
        q_values: Tensor = self.output_units(self.output(self.hidden_units(self.hidden(x))))
        return q_values


def new_network(contract: PolicyContract, learner: LearnerConfig, seed: int) -> QNetwork:
    """A float64 network with the initial weights of a seed."""
    inputs, actions = contract.retina.frames * contract.retina.size, len(contract.actions)
    network = QNetwork(inputs, actions, learner).double()
    generator = np.random.default_rng([seed, inputs, learner.hidden, actions])
    for layer in (network.hidden, network.output):
        _draw(layer, learner, generator)
    return network


def _draw(layer: nn.Linear, learner: LearnerConfig, generator: np.random.Generator) -> None:
    """Draws with NumPy, whose streams are promised to stay; torch's are not."""
    normal = learner.initial_weights == "normal"
    scale = 1.0 if normal else 1.0 / math.sqrt(layer.in_features)
    with torch.no_grad():
        layer.weight.copy_(torch.from_numpy(scale * generator.normal(size=layer.weight.shape)))
        bias = generator.normal(size=layer.bias.shape) * float(normal)
        layer.bias.copy_(torch.from_numpy(bias))
