"""The online learner's values and gradients, against torch and autograd."""

from typing import Any

import numpy as np
import pytest
import torch

from reflexarc_trainer.config.train_config import (
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
    TrainConfig,
)
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.sarsa.online import network_pass
from reflexarc_trainer.sarsa.online.learner import sizes_of
from reflexarc_trainer.sarsa.online.weight_rows import from_online
from support.compiled_calls import from_python
from support.learning import gradient_of, set_up

fill_gradient = from_python(network_pass.fill_gradient)
forward = from_python(network_pass.forward)
CONTRACT = TrainConfig().contract()
SIZES = sizes_of(TrainConfig())


@pytest.mark.parametrize("units", ["sigmoid", "tanh", "relu"])
@pytest.mark.parametrize("output", ["linear", "sigmoid"])
@pytest.mark.parametrize(("precision", "tolerance"), [("float64", 1e-12), ("float32", 1e-5)])
def test_compiled_value_and_gradient_are_those_of_autograd(
    units: Any, output: Any, precision: Any, tolerance: float
) -> None:
    network_config = NetworkConfig(
        units=units, output=output, initial_weights="normal", input_power=3
    )
    learner = LearnerConfig(online=OnlineConfig(precision=precision))
    config = TrainConfig(network=network_config, learner=learner)
    rules, _, scratch = set_up(config)
    network = new_network(CONTRACT, config.network, config.seed)
    for seed in range(20):
        retinas = np.random.default_rng(seed).integers(0, 256, (2, 16), np.uint8)
        scratch.inputs[:] = (retinas / 255) ** 3
        forward(rules, scratch)
        q_values = network(torch.from_numpy(retinas.reshape(2, 1, 1, 16, 1))).detach().numpy()
        np.testing.assert_allclose(scratch.q_values[:, :3], q_values, rtol=0, atol=tolerance)
        fill_gradient(rules, scratch, seed % 3)
        expected = gradient_of(network, retinas[0], seed % 3)
        mine = from_online(scratch.gradient, *SIZES)
        np.testing.assert_allclose(mine, expected, rtol=0, atol=tolerance)
