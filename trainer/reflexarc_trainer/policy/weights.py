"""Conversion between the torch network and a flat vector of its weights.

The vector's order is torch's own: for each layer W as rows (outputs, inputs), then its biases.
Learners, checkpoints and policies exchange weights in this order.
"""

import numpy as np
import numpy.typing as npt
import torch
from torch.nn.utils import parameters_to_vector, vector_to_parameters

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import Policy
from reflexarc_trainer.config.learner_config import NetworkConfig
from reflexarc_trainer.policy.q_network import QNetwork, empty_network
from reflexarc_trainer.sarsa.learner_interface import Learner

Weights = npt.NDArray[np.float64]
"""All weights and biases of a network: (parameters,)."""


def pack(network: torch.nn.Module) -> npt.NDArray[np.float64]:
    """The weights of a network as one vector (parameters,)."""
    return parameters_to_vector(network.parameters()).detach().double().numpy().copy()


def unpack(
    weights: npt.NDArray[np.floating], contract: PolicyContract, config: NetworkConfig
) -> QNetwork:
    """A float64 network that holds the weights of a vector (parameters,)."""
    network = empty_network(contract, config)
    vector_to_parameters(torch.from_numpy(weights.astype(np.float64)), network.parameters())
    return network


def network_of(learner: Learner) -> QNetwork:
    """The learned weights as a network."""
    return unpack(learner.weights, learner.config.contract(), learner.config.network)


class NetworkPolicy(Policy):
    """A network as a greedy `Policy`, computed by torch in the network's precision."""

    def __init__(self, network: torch.nn.Module) -> None:
        self._network = network

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Q-values (n, actions), actions (n,) of retinas (n, frames, eyes, rays, channels)."""
        with torch.no_grad():
            q_values = self._network(torch.from_numpy(retinas)).numpy().astype(np.float32)
        return q_values, np.argmax(q_values, axis=1)
