"""The optimiser against torch's."""

from typing import Any

import numpy as np
import pytest
import torch

from reflexarc_trainer.sarsa.batched import optimiser
from reflexarc_trainer.sarsa.batched.optimiser import new_moments
from support.compiled_calls import from_python

clip_norm = from_python(optimiser.clip_norm)
descend = from_python(optimiser.descend)


@pytest.mark.parametrize("rectified", [False, True])
def test_weights_move_as_torch_moves_them(rectified: bool) -> None:
    generator = np.random.default_rng(0)
    weights, moments = generator.normal(size=40), new_moments(40, np.float64)
    parameter = torch.nn.Parameter(torch.from_numpy(weights.copy()))
    kind: Any = torch.optim.RAdam if rectified else torch.optim.Adam
    optimiser = kind([parameter], lr=0.01)
    for _ in range(60):
        gradient = generator.normal(size=40) * generator.uniform(0.01, 10.0)
        parameter.grad = torch.from_numpy(gradient.copy())
        optimiser.step()
        descend(weights, gradient, moments, 0.01, rectified)
        # torch adds its epsilon to RAdam's root before the correction, and to Adam's after it.
        np.testing.assert_allclose(weights, parameter.detach().numpy(), rtol=0, atol=1e-9)


@pytest.mark.parametrize("longest", [0.5, 100.0])
def test_long_gradient_is_shortened_as_torch_shortens_it(longest: float) -> None:
    gradient = np.random.default_rng(0).normal(size=40)
    parameter = torch.nn.Parameter(torch.zeros(40, dtype=torch.float64))
    parameter.grad = torch.from_numpy(gradient.copy())
    norm = torch.nn.utils.clip_grad_norm_([parameter], longest)
    assert clip_norm(gradient, longest) == pytest.approx(float(norm))
    np.testing.assert_allclose(gradient, parameter.grad.numpy(), rtol=1e-12)
