"""Between the torch network and the flat vector of weights that the compiled learner changes.

The layout is that of `online.py`: W₁ with b₁ as its last row, (I + 1, H); then W₂ with b₂ as its
last column, (A, H + 1).
"""

import numpy as np
import numpy.typing as npt
import torch

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.policy import Policy
from reflexarc_trainer.config import LearnerConfig
from reflexarc_trainer.q_network import QNetwork


def pack(network: QNetwork) -> npt.NDArray[np.float64]:
    """The weights of a network as one vector (parameters,)."""
    w1, b1, w2, b2 = (p.detach().double().numpy() for p in network.parameters())
    return np.concatenate([np.vstack([w1.T, b1]).ravel(), np.column_stack([w2, b2]).ravel()])


def unpack(
    weights: npt.NDArray[np.float64], contract: PolicyContract, learner: LearnerConfig
) -> QNetwork:
    """A float64 network that holds the weights of a vector (parameters,)."""
    inputs, actions = contract.retina.frames * contract.retina.size, len(contract.actions)
    network = QNetwork(inputs, actions, learner).double()
    first, second = np.split(weights, [(inputs + 1) * learner.hidden])
    first, second = first.reshape(inputs + 1, -1), second.reshape(actions, -1)
    parts = (first[:-1].T, first[-1], second[:, :-1], second[:, -1])
    with torch.no_grad():
        for parameter, part in zip(network.parameters(), parts, strict=True):
            parameter.copy_(torch.from_numpy(part.copy()))
    return network


class NetworkPolicy(Policy):
    """A network as a `Policy`: what it would do greedily, computed in its own precision."""

    def __init__(self, network: torch.nn.Module) -> None:
        self._network = network

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Q-values (n, actions) and winners (n,) of retinas (n, frames, eyes, rays, channels)."""
        with torch.no_grad():
            q_values = self._network(torch.from_numpy(retinas)).numpy().astype(np.float32)
        return q_values, np.argmax(q_values, axis=1)
