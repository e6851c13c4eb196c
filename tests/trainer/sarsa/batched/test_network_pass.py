"""Forward and backward over blocks of agents, against torch and autograd."""

import itertools
from typing import Any

import numpy as np
import pytest
import torch

from reflexarc_trainer.config.train_config import NetworkConfig, TrainConfig
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.weights import pack
from reflexarc_trainer.sarsa.batched import network_pass
from reflexarc_trainer.sarsa.network_shape import input_curve, layers_for
from support.compiled_calls import from_python

backward = from_python(network_pass.backward)
forward = from_python(network_pass.forward)
CONTRACT = TrainConfig().contract()
HIDDEN = [(1,), (10,), (64,), (9, 6), (7, 5, 6)]
UNITS: list[Any] = ["sigmoid", "tanh", "relu"]
OUTPUTS: list[Any] = ["linear", "sigmoid"]


@pytest.mark.parametrize(
    ("hidden", "units", "output"), list(itertools.product(HIDDEN, UNITS, OUTPUTS)), ids=str
)
def test_gradient_is_that_of_autograd_for_every_network(
    hidden: tuple[int, ...], units: Any, output: Any
) -> None:
    config = NetworkConfig(hidden, units, output, input_power=2, initial_weights="normal")
    network = new_network(CONTRACT, config, seed=1)
    retinas = np.random.default_rng(0).integers(0, 256, (13, 1, 1, 16, 1), np.uint8)
    targets = np.random.default_rng(1).normal(size=(13, 3))
    q_values = network(torch.from_numpy(retinas))
    loss = 0.5 * ((q_values - torch.from_numpy(targets)) ** 2).sum()
    gradients = torch.autograd.grad(loss, list(network.parameters()))
    expected = np.concatenate([g.numpy().ravel() for g in gradients])

    for dtype, tolerance in ((np.float64, 1e-9), (np.float32, 3e-4)):
        layers, weights = layers_for(config, CONTRACT), pack(network).astype(dtype)
        inputs = np.ascontiguousarray(input_curve(config, dtype)[retinas.reshape(13, 16).T])
        values = np.zeros((layers.computed, 13), dtype)
        back, gradient = np.zeros_like(values), np.zeros_like(weights)
        forward(layers, weights, inputs, values)
        np.testing.assert_allclose(values[-3:].T, q_values.detach().numpy(), atol=tolerance)
        back[-3:] = values[-3:] - targets.T.astype(dtype)
        backward(layers, weights, inputs, values, back, gradient)
        scale = np.abs(expected).max()
        np.testing.assert_allclose(gradient / scale, expected / scale, rtol=0, atol=tolerance)
