"""torch's recurrent modules as ONNX: the oracle is torch's own call over a whole sequence."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import within_tolerance
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import export

UNITS = 6


def contract_of(memory: int, frames: int = 1) -> PolicyContract:
    return PolicyContract(retina=RetinaSpec(frames=frames), state=StateSpec(size=memory))


class Layers(nn.Module):
    """An `nn.GRU` or `nn.LSTM`, its memory flat in the state: h of every layer, then c."""

    def __init__(self, kind: str, layers: int, batch_first: bool, bias: bool = True) -> None:
        super().__init__()
        make = {"GRU": nn.GRU, "LSTM": nn.LSTM}[kind]
        self.core = make(16, UNITS, layers, bias=bias, batch_first=batch_first, dtype=torch.float64)
        self.head = nn.Linear(UNITS, 3, dtype=torch.float64)
        self.kind, self.layers, self.batch_first = kind, layers, batch_first

    @property
    def parts(self) -> int:
        return {"GRU": 1, "LSTM": 2}[self.kind]

    @property
    def memory(self) -> int:
        return self.parts * self.layers * UNITS

    def unpacked(self, state: Tensor) -> Any:
        """(n, memory) → (layers, n, units), twice for an LSTM."""
        parts = state.view(state.shape[0], self.parts * self.layers, UNITS).transpose(0, 1)
        return parts if self.kind == "GRU" else parts.contiguous().chunk(2)

    def packed(self, memory: Any) -> Tensor:
        parts = memory if self.kind == "GRU" else torch.cat([memory[0], memory[1]])
        return parts.permute(1, 0, 2).reshape(-1, self.memory)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        x = x.flatten(1).unsqueeze(1 if self.batch_first else 0)
        y, memory = self.core(x, self.unpacked(state))
        q_values = self.head(y)[:, -1] if self.batch_first else self.head(y[0])
        return q_values, self.packed(memory)


class Cell(nn.Module):
    """An `nn.GRUCell` or `nn.LSTMCell`, sliced out of the state by hand."""

    def __init__(self, kind: str) -> None:
        super().__init__()
        self.cell = {"GRU": nn.GRUCell, "LSTM": nn.LSTMCell}[kind](16, UNITS, dtype=torch.float64)
        self.head = nn.Linear(UNITS, 3, dtype=torch.float64)
        self.kind, self.memory = kind, UNITS if kind == "GRU" else 2 * UNITS

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        x = torch.flatten(x, 1)
        if self.kind == "GRU":
            h = self.cell(x, state)
            return self.head(h), h
        h, c = self.cell(x, (state[:, :UNITS], state[:, UNITS:]))
        return self.head(h), torch.cat((h, c), dim=-1)


MODULES = {
    "GRU": lambda: Layers("GRU", 1, True),
    "GRU, time first": lambda: Layers("GRU", 1, False),
    "GRU, three layers": lambda: Layers("GRU", 3, True),
    "GRU, no bias": lambda: Layers("GRU", 2, False, bias=False),
    "LSTM": lambda: Layers("LSTM", 1, True),
    "LSTM, time first": lambda: Layers("LSTM", 1, False),
    "LSTM, two layers": lambda: Layers("LSTM", 2, True),
    "LSTM, no bias": lambda: Layers("LSTM", 2, False, bias=False),
    "GRU cell": lambda: Cell("GRU"),
    "LSTM cell": lambda: Cell("LSTM"),
}


def made(name: str) -> Any:
    torch.manual_seed(3)
    return MODULES[name]()


def retinas_of(count: int, frames: int = 1) -> npt.NDArray[np.uint8]:
    shape = (count, frames, 1, 16, 1)
    return np.random.default_rng(8).integers(0, 256, shape, np.uint8)


def as_in_file(module: nn.Module) -> nn.Module:
    return module.float().double().eval()


@pytest.mark.parametrize("name", MODULES)
def test_every_backend_says_what_torch_says_for_any_memory(name: str, tmp_path: Path) -> None:
    module, retinas = made(name), retinas_of(400)
    written = export(module, contract_of(module.memory), tmp_path / "p.onnx")
    memories = np.random.default_rng(9).uniform(-1, 1, (400, module.memory)).astype(np.float32)
    with torch.no_grad():
        pixels, state = torch.from_numpy(retinas / 255.0), torch.from_numpy(memories).double()
        q_values, following = (t.numpy() for t in as_in_file(module)(pixels, state))
    for backend, tolerance in (("numpy", 1.2e-7), ("onnxruntime", written.q_tolerance)):
        got = load_policy(tmp_path / "p.onnx", backend).decide(retinas, memories)
        assert within_tolerance(got[0], q_values.astype(np.float32), tolerance)
        assert within_tolerance(got[2], following.astype(np.float32), tolerance)


@pytest.mark.parametrize("name", [name for name in MODULES if "cell" not in name])
def test_step_by_step_it_says_what_torch_says_of_the_whole_sequence(
    name: str, tmp_path: Path
) -> None:
    module, retinas = made(name), retinas_of(25)
    export(module, contract_of(module.memory), tmp_path / "p.onnx")
    policy = load_policy(tmp_path / "p.onnx")
    memories, values = np.zeros((1, module.memory), np.float32), []
    for retina in retinas[:, np.newaxis]:
        q_values, _, memories = policy.decide(retina, memories)
        values.append(q_values[0])
    module = as_in_file(module)
    sequence = torch.from_numpy(retinas.reshape(25, 1, 16) / 255.0)
    with torch.no_grad():
        hidden, _ = module.core(sequence.transpose(0, 1) if module.batch_first else sequence)
        expected = module.head(hidden).reshape(25, 3).numpy()
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", MODULES)
def test_golden_sequences_hold_on_both_backends(name: str, tmp_path: Path) -> None:
    module = made(name)
    written = export(module, contract_of(module.memory), tmp_path / "p.onnx")
    assert [len(s.retinas) for s in written.golden.sequences] == [20, 20]
    for backend in ("numpy", "onnxruntime"):
        assert load_policy(tmp_path / "p.onnx", backend).contract == written


def test_frames_may_be_the_sequence_of_a_policy_without_a_memory(tmp_path: Path) -> None:
    class OverFrames(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.core = nn.LSTM(16, UNITS, batch_first=True, dtype=torch.float64)
            self.head = nn.Linear(UNITS, 3, dtype=torch.float64)

        def forward(self, x: Tensor) -> Tensor:
            y, _ = self.core(x.flatten(2))
            q_values: Tensor = self.head(y[:, -1])
            return q_values

    module, retinas = OverFrames(), retinas_of(50, frames=4)
    export(module, contract_of(0, frames=4), tmp_path / "p.onnx")
    with torch.no_grad():
        expected = as_in_file(module)(torch.from_numpy(retinas / 255.0)).numpy()
    q_values, _ = load_policy(tmp_path / "p.onnx").decide(retinas)
    np.testing.assert_allclose(q_values, expected, rtol=0, atol=1e-6)


class Wrapped(nn.Module):
    """Gives a recurrent module its inputs, whatever comes of it."""

    def __init__(self, core: nn.Module, directions: int = 1, batch_first: bool = True) -> None:
        super().__init__()
        self.core, self.directions, self.batch_first = core, directions, batch_first

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        x = x.flatten(1).unsqueeze(1 if self.batch_first else 0)
        y, h = self.core(x, torch.stack([state] * self.directions))
        return y[:, 0, :3] if self.batch_first else y[0, :, :3], h[0]


class Projected(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.core = nn.LSTM(16, 8, batch_first=True, proj_size=UNITS)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        y, (h, _) = self.core(x.flatten(1).unsqueeze(1))
        return y[:, 0, :3], h[0] + state


class NotFirst(nn.Module):
    """Takes the batch for the sequence: what others in the batch see would be remembered."""

    def __init__(self) -> None:
        super().__init__()
        self.core = nn.GRU(16, UNITS)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        y, _ = self.core(x.flatten(1).unsqueeze(1))
        return y[:, 0, :3], y[:, 0] + state


class OneInput(nn.Module):
    def forward(self, x: Tensor) -> Tensor:
        return x.flatten(1)[:, :3]


class OneOutput(nn.Module):
    def forward(self, x: Tensor, state: Tensor) -> Tensor:
        return x.flatten(1)[:, :3] + state[:, :3]


class Summing(nn.Module):
    """Sums along its memory, which no table has."""

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        return x.flatten(1)[:, :3], state * torch.cumsum(state, 1)


@pytest.mark.parametrize(
    ("module", "message"),
    [
        (Wrapped(nn.GRU(16, UNITS, batch_first=True, bidirectional=True), 2), "bidirectional=True"),
        (Projected(), f"proj_size={UNITS}"),
        (NotFirst(), r"expected an input \(steps, n, inputs\) .* got \(n, 1, 16\)"),
        (Wrapped(nn.RNN(16, UNITS, batch_first=True)), "operator RNN"),
        (Wrapped(nn.GRU(16, 5, batch_first=True)), "fails on retinas"),
        (Layers("LSTM", 1, True), "fails on retinas"),
        (OneInput(), "fails on retinas"),
        (OneOutput(), r"expected Q-values and next states .*state\.size is 6\), got 1"),
        (Summing(), "operator cumsum"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    module: nn.Module, message: str, tmp_path: Path
) -> None:
    with pytest.raises(PolicyError, match=message) as refusal:
        export(module, contract_of(UNITS), tmp_path / "p.onnx")
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


def test_a_state_of_another_size_is_refused_in_one_line(tmp_path: Path) -> None:
    class Growing(nn.Module):
        def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
            return x.flatten(1)[:, :3], torch.cat([state, state], 1)

    with pytest.raises(PolicyError, match=r"expected next states .*state\.size and the module"):
        export(Growing(), contract_of(UNITS), tmp_path / "p.onnx")


def test_a_start_value_counts(tmp_path: Path) -> None:
    module = made("GRU")
    start = tuple(float(v) for v in np.linspace(-1, 1, UNITS).astype(np.float32))
    contract = dataclasses.replace(contract_of(UNITS), state=StateSpec(UNITS, start))
    written = export(module, contract, tmp_path / "p.onnx")
    retina = np.array(written.golden.sequences[0].retinas[0], np.uint8).reshape(1, 1, 1, 16, 1)
    memories = np.array([start], np.float32)
    q_values = load_policy(tmp_path / "p.onnx").decide(retina, memories)[0]
    assert tuple(q_values[0].tolist()) == written.golden.sequences[0].q_values[0]
