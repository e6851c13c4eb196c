"""The network in torch: retina → hidden layers → one Q-value per action (the paper: 16–10–3).

With one hidden layer of sigmoid units, Q(s, ·) = W₂ σ(W₁ xᵖ + b₁) + b₂, where x is the retina in
[0, 1] and p the input power; with sigmoid output units, Q is σ of this.
"""

from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.utils import vector_to_parameters

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.config.learner_config import NetworkConfig
from reflexarc_trainer.sarsa.initial_weights import drawn_weights

_UNITS: dict[str, type[nn.Module]] = {
    "sigmoid": nn.Sigmoid,
    "tanh": nn.Tanh,
    "relu": nn.ReLU,
    "linear": nn.Identity,
}


def intensity(retinas: Tensor) -> Tensor:
    """Retinas as floats in [0, 1]: bytes become float64 / 255, floats are taken as they are."""
    return retinas if retinas.is_floating_point() else retinas.double() / FULL_SCALE


# The exporter traces the module. This keeps the call one node of the trace, which its table knows.
torch.fx.wrap("intensity")


class QNetwork(nn.Module):
    """The Q-values of retinas.

    Args:
        inputs: number of values of a retina stack.
        actions: number of actions.
        config: layers, units and input power.
    """

    def __init__(self, inputs: int, actions: int, config: NetworkConfig) -> None:
        super().__init__()
        sizes = (inputs, *config.hidden)
        hidden = (
            (nn.Linear(below, here, dtype=torch.float64), _UNITS[config.units]())
            for below, here in pairwise(sizes)
        )
        self.input_power = config.input_power
        self.flatten = nn.Flatten()
        self.hidden = nn.Sequential(*(part for layer in hidden for part in layer))
        self.output = nn.Linear(sizes[-1], actions, dtype=torch.float64)
        self.output_units = _UNITS[config.output]()

    def forward(self, retinas: Tensor) -> Tensor:
        """Q-values (n, actions) of retinas (n, frames, eyes, rays, channels).

        Args:
            retinas: uint8 (then the weights must be float64), or floats in [0, 1].
        """
        x = raised(self.flatten(intensity(retinas)), self.input_power)
        q_values: Tensor = self.output_units(self.output(self.hidden(x)))
        return q_values


def raised(x: Tensor, power: int) -> Tensor:
    """Raise to a whole power by multiplications only, which every backend of the graph has."""
    if power == 1:
        return x
    half = raised(x, power // 2)
    squared = half * half
    return squared * x if power % 2 else squared


def new_network(contract: PolicyContract, config: NetworkConfig, seed: int) -> QNetwork:
    """A float64 network with the initial weights of a seed."""
    network = empty_network(contract, config)
    weights = torch.from_numpy(drawn_weights(contract, config, seed))
    vector_to_parameters(weights, network.parameters())
    return network


def empty_network(contract: PolicyContract, config: NetworkConfig) -> QNetwork:
    """A float64 network with torch's own initial weights, to be replaced by others."""
    sizes = config.sizes(contract)
    return QNetwork(sizes[0], sizes[-1], config)
