"""What cuts, joins and turns tensors is exported as torch does it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import export

CONTRACT = PolicyContract(retina=RetinaSpec(rays=6, frames=4))
RETINAS = np.random.default_rng(2).integers(0, 256, (40, 4, 1, 6, 1), np.uint8)


class Shaped(nn.Module):
    """Retinas (n, 4, 1, 6, 1) → three of the values that a function makes of (n, 4, 6)."""

    def __init__(self, shape: Callable[[Tensor], Tensor]) -> None:
        super().__init__()
        self.shape = shape

    def forward(self, x: Tensor) -> Tensor:
        return self.shape(x.reshape(-1, 4, 6)).flatten(1)[:, 2:5]


SHAPES: dict[str, Callable[[Tensor], Tensor]] = {
    "cat": lambda x: torch.cat([x[:, 1:], x, x[:, :2]], dim=-2),
    "cat over the default axis of rows": lambda x: torch.concat((x, x), 2),
    "stack": lambda x: torch.stack([x[:, 0], x[:, 3]], dim=-1),
    "chunk": lambda x: x.chunk(4, 1)[2] - torch.chunk(x, 3, dim=2)[1].reshape(-1, 1, 8)[:, :, :6],
    "chunk, unpacked": lambda x: weighed_halves(x),
    "split by size": lambda x: torch.split(x, 4, dim=2)[1],
    "split by sizes": lambda x: x.split([1, 3], dim=1)[1],
    "unsqueeze": lambda x: x.unsqueeze(-1) * torch.unsqueeze(x, 1).permute(0, 2, 3, 1),
    "squeeze": lambda x: x[:, 1:2].squeeze(1) + x[:, :1].squeeze(),
    "squeeze of nothing": lambda x: x.squeeze(1),
    "squeeze of several": lambda x: x.view(-1, 1, 24, 1).squeeze((1, -1)),
    "transpose": lambda x: x.transpose(1, 2),
    "transpose from the end": lambda x: torch.transpose(x, -1, -2),
    "permute": lambda x: x.permute(0, 2, 1),
    "permute, a list": lambda x: torch.permute(x, (0, -1, 1)),
    "view with the size of the batch": lambda x: x.view(x.shape[0], -1),
    "view with a size": lambda x: x.reshape(x.size(0), 2, x.size(1) * 3),
    "flatten from the end": lambda x: x.flatten(-2),
    "flatten of part": lambda x: torch.flatten(x.unsqueeze(1), 1, 2),
    "unflatten": lambda x: x.unflatten(2, (3, 2)).transpose(1, 3).contiguous(),
    "index": lambda x: x[:, 2],
    "index from the end": lambda x: x[:, -1] - x[..., -1:, :].squeeze(1),
    "index of two": lambda x: x[:, 1:, ::2],
    "ellipsis": lambda x: x[..., 1:4],
    "new axis": lambda x: x[:, None, 1, ..., None],
    "one new axis at the end": lambda x: x[..., None],
    "a number of the shape": lambda x: x / x.shape[2],
}


def weighed_halves(x: Tensor) -> Tensor:
    left, right = x.chunk(2, dim=-1)
    return left + 2.0 * right


@pytest.mark.parametrize("name", SHAPES)
def test_every_way_is_exported_as_torch_does_it(name: str, tmp_path: Path) -> None:
    module = Shaped(SHAPES[name])
    export(module, CONTRACT, tmp_path / "p.onnx")
    expected = module(torch.from_numpy(RETINAS / 255.0)).numpy().astype(np.float32)
    for backend in ("numpy", "onnxruntime"):
        q_values, _ = load_policy(tmp_path / "p.onnx", backend).decide(RETINAS)
        np.testing.assert_allclose(q_values, expected, rtol=0, atol=2e-6)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (lambda x: x / x.shape[0], "depends on the size of the batch"),
        (lambda x: x[0].unsqueeze(0) + x, "an index into the batch"),
        (lambda x: x[:, torch.tensor([0, 1])], "an index of"),
        (lambda x: torch.cat(x.split(1, 0)) if x.ndim else x, "cannot be traced|batch cannot"),
        (lambda x: (x.reshape(-1) @ x.reshape(-1)) + x, "one retina at a time and with many"),
        (lambda x: torch.cat([x, x], dim=1, out=None), "arguments out are not supported"),
        (lambda x: x.roll(1), "operator roll"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    shape: Callable[[Tensor], Tensor], message: str, tmp_path: Path
) -> None:
    with pytest.raises(PolicyError, match=message) as refusal:
        export(Shaped(shape), CONTRACT, tmp_path / "p.onnx")
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())
