"""Functions and methods of torch are exported as torch computes them: one line for each way."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional as F  # noqa: N812  # its usual name

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import as_exported, export

CONTRACT = PolicyContract(retina=RetinaSpec(rays=6, frames=4))
RETINAS = np.random.default_rng(3).integers(0, 256, (60, 4, 1, 6, 1), np.uint8)


class Of(nn.Module):
    """Retinas (n, 4, 1, 6, 1) → three of the values that a function makes of (n, 4, 6) in ±3."""

    def __init__(self, function: Callable[[Tensor], Tensor]) -> None:
        super().__init__()
        self.function = function

    def forward(self, x: Tensor) -> Tensor:
        return self.function(x.reshape(-1, 4, 6) * 6.0 - 3.0).flatten(1)[:, 2:5]


FUNCTIONS: dict[str, Callable[[Tensor], Tensor]] = {
    "leaky_relu": lambda x: F.leaky_relu(x, 0.3, inplace=False),
    "elu": lambda x: F.elu(x, alpha=0.5),
    "celu": lambda x: F.celu(x, 0.7),
    "selu": lambda x: F.selu(x) + torch.selu(x),
    "gelu": lambda x: F.gelu(x) - F.gelu(x, approximate="tanh"),
    "silu": lambda x: F.silu(x),
    "mish": lambda x: F.mish(x),
    "softplus": lambda x: F.softplus(x, 3) + F.softplus(x),
    "logsigmoid": lambda x: F.logsigmoid(x),
    "softsign": lambda x: F.softsign(x),
    "hardtanh": lambda x: F.hardtanh(x, -0.5, 2.0),
    "relu6": lambda x: F.relu6(x + 3.0),
    "hardsigmoid": lambda x: F.hardsigmoid(x) * F.hardswish(x),
    "glu": lambda x: F.glu(x, dim=2),
    "clamp": lambda x: x.clamp(-1.0, 0.5) + x.clamp(max=0.25) + torch.clamp(x, min=-0.5),
    "softmax": lambda x: x.softmax(dim=-1) + F.softmax(x, dim=1),
    "log_softmax": lambda x: torch.log_softmax(x, 2) - x.log_softmax(dim=1),
    "layer_norm": lambda x: F.layer_norm(x, (6,)) + F.layer_norm(x, [4, 6], eps=0.01),
    "rms_norm": lambda x: F.rms_norm(x, (6,), eps=1e-3),
    "mean": lambda x: x.mean(dim=1) + x.mean(-1).mean(1, True),
    "sum": lambda x: torch.sum(x, (1, 2)).unsqueeze(1) + x.sum(axis=1),
    "extremes": lambda x: x.amax(1) + torch.amin(x, dim=1) + x.max(dim=1).values - x.min(1)[0],
    "extremes of two": lambda x: torch.max(x, -x) + torch.maximum(x, x * 2) - torch.min(x, x * x),
    "places": lambda x: x.max(1).indices.float() + x.min(1)[1].double(),
    "where": lambda x: torch.where(x > 0.123, x, -2.0) + torch.where(x.le(0.321), x, x * 2.0),
    "comparisons": lambda x: (x >= 0.1011).float() + (x < -0.1011).double() + (x != 3.0).float(),
    "powers": lambda x: x**2 + x.pow(3) - torch.pow(x.abs() + 1.0, 1.5) + torch.square(x) - x**4,
    "roots": lambda x: torch.rsqrt(x.abs() + 1.0) + x.abs().sqrt() + torch.reciprocal(x * x + 2),
    "exp, log": lambda x: x.exp() - torch.log(x.abs() + 0.5) + torch.sin(x) * torch.cos(x),
    "numbers first": lambda x: 2.0 - x + 1.0 / (x.abs() + 1.0) - (-x) + torch.rsub(x, 3.0),
    "a product of two": lambda x: x @ x.transpose(1, 2) @ x,
    "pad around a ring": lambda x: F.pad(x, (2, 1), mode="circular"),
    "pad by the edge": lambda x: F.pad(x, (3, 0), mode="replicate"),
    "pad by reflection": lambda x: F.pad(x, (2, 3), mode="reflect"),
    "pad with a number": lambda x: F.pad(x, (2, 0, 1, 0), value=0.5) + F.pad(x, (2, 0, 1, 0)),
    "max pool": lambda x: F.max_pool1d(x, 3, stride=2, padding=1, dilation=1),
    "mean pool": lambda x: F.avg_pool1d(x, 2, 2) + F.avg_pool1d(x, 3, 2, 1, False, False),
    "pools to a size": lambda x: F.adaptive_avg_pool1d(x, 3) + F.adaptive_max_pool1d(x, 1),
    "dropout": lambda x: F.dropout(x, 0.5, training=False),
    "a cast": lambda x: x.to(torch.float32).float() * 2,
    "linear": lambda x: F.linear(x, torch.ones(3, 6), torch.tensor([1.0, 2.0, 3.0])),
}
JUMPS = ("places", "where", "comparisons")


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_way_is_exported_as_torch_does_it(name: str, tmp_path: Path) -> None:
    module = Of(FUNCTIONS[name])
    written = export(module, CONTRACT, tmp_path / "p.onnx")
    assert written.q_tolerance < (1e-3 if name not in JUMPS else 0.1)
    said = as_exported(module)(torch.from_numpy(RETINAS / 255.0))
    expected = said.numpy().astype(np.float32)
    for backend in ("numpy", "onnxruntime"):
        q_values, _ = load_policy(tmp_path / "p.onnx", backend).decide(RETINAS)
        np.testing.assert_allclose(q_values, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda x: x - x.mean(), "over the batch"),
        (lambda x: x.max() * x, "over the batch"),
        (lambda x: F.softmax(x, 0), "over the batch"),
        (lambda x: F.layer_norm(x, (4, 6)) + x.sum(0), "over the batch"),
        (lambda x: F.dropout(x, training=True), "draws at random"),
        (lambda x: F.avg_pool1d(x, 4, 4, ceil_mode=True), "ends outside"),
        (lambda x: F.adaptive_avg_pool1d(x, 4), "sizes that divide"),
        (lambda x: F.pad(x, (7, 0), mode="circular"), "wrapping around more than once"),
        (lambda x: F.pad(x, (-1, 0)), "a negative one"),
        (lambda x: F.softplus(x, 1.0, 2.0), "threshold below 20"),
        (lambda x: x.cumsum(1), "operator cumsum"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    function: Callable[[Tensor], Tensor], message: str, tmp_path: Path
) -> None:
    with pytest.raises(PolicyError, match=message) as refusal:
        export(Of(function), CONTRACT, tmp_path / "p.onnx")
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


def test_a_norm_of_the_batch_without_statistics_is_refused(tmp_path: Path) -> None:
    module = nn.Sequential(
        nn.Flatten(), nn.BatchNorm1d(24, track_running_stats=False), nn.Linear(24, 3)
    )
    with pytest.raises(PolicyError, match="without running statistics"):
        export(module, CONTRACT, tmp_path / "p.onnx")
