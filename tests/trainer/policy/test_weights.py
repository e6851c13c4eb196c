"""Networks as vectors of weights, and back."""

import torch

from reflexarc_trainer.config.train_config import (
    NetworkConfig,
    TrainConfig,
)
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.weights import pack, unpack

CONTRACT = TrainConfig().contract()


def test_packing_and_unpacking_gives_the_same_network() -> None:
    config = NetworkConfig(hidden=(5, 4), initial_weights="normal")
    network = new_network(CONTRACT, config, seed=2)
    again = unpack(pack(network), CONTRACT, config)
    for mine, other in zip(network.parameters(), again.parameters(), strict=True):
        assert torch.equal(mine, other)
