"""Networks of users: each backend says what torch says, whatever their kind and their weights."""

from pathlib import Path

import numpy as np
import pytest
import torch

from reflexarc_runtime.policy.agreement import flips, within_tolerance
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import as_exported, export
from support.architectures import ARCHITECTURES, contract_of, network

RETINAS = np.random.default_rng(41).integers(0, 256, (200, 1, 1, 16, 1), np.uint8)


@pytest.mark.parametrize("gain", [1.0, 20.0])
@pytest.mark.parametrize("name", ARCHITECTURES)
def test_every_backend_says_what_torch_says(name: str, gain: float, tmp_path: Path) -> None:
    module, contract, path = network(name, gain, seed=3), contract_of(name), tmp_path / "p.onnx"
    written = export(module, contract, path)
    inputs = [torch.from_numpy(RETINAS / 255.0)]
    memories = start_of(contract, len(RETINAS))
    if memories is not None:
        inputs.append(torch.from_numpy(memories).double())
    with torch.no_grad():
        said = as_exported(module)(*inputs)
    said = said[0] if isinstance(said, tuple) else said
    expected = said.numpy().astype(np.float32)
    for backend in ("numpy", "onnxruntime"):
        q_values, actions = load_policy(path, backend).decide(RETINAS)
        assert within_tolerance(q_values, expected, written.q_tolerance)
        winners = expected.argmax(axis=1)
        assert not flips(actions, winners, expected, written.q_tolerance).any()
