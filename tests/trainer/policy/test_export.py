"""The policy file: the same policy for torch, NumPy and onnxruntime, or no file at all."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
import pytest
import torch
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import flips, within_tolerance
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import NetworkConfig
from reflexarc_trainer.policy import parity
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.torch_parity import torch_decide

CONTRACT = PolicyContract()


def random_retinas(contract: PolicyContract, count: int = 1000) -> npt.NDArray[np.uint8]:
    shape = (count, *contract.retina.stack_shape)
    return np.random.default_rng(77).integers(0, 256, shape, np.uint8)


def torch_q_values(module: nn.Module, retinas: npt.NDArray[np.uint8]) -> npt.NDArray[np.float64]:
    """What the module says in float64, its weights rounded to those of the file."""
    rounded = module.float().double().eval()
    with torch.no_grad():
        q_values: npt.NDArray[np.float64] = rounded(torch.from_numpy(retinas / 255.0)).numpy()
    return q_values


class Residual(nn.Module):
    """Adds, multiplies, and owns a bare parameter."""

    def __init__(self) -> None:
        super().__init__()
        self.first, self.last = nn.Linear(16, 16), nn.Linear(16, 3)
        self.gain = nn.Parameter(torch.full((16,), 0.7))

    def forward(self, x: Tensor) -> Tensor:
        x = torch.flatten(x, 1)
        x = torch.relu(self.first(x)) * self.gain + x
        last: Tensor = self.last(torch.tanh(x - 0.25))
        return last


def modules() -> dict[str, nn.Module]:
    torch.manual_seed(0)
    normal = NetworkConfig(output="sigmoid", initial_weights="normal")
    deep = NetworkConfig(hidden=(9, 8, 7), units="tanh", output="linear", input_power=13)
    return {
        "network": new_network(CONTRACT, NetworkConfig(), 0),
        "sigmoid network": new_network(CONTRACT, normal, 0),
        "deep network": new_network(CONTRACT, deep, 0),
        "sequential": nn.Sequential(
            nn.Flatten(), nn.Linear(16, 8), nn.ReLU(), nn.Dropout(), nn.Linear(8, 3, bias=False)
        ),
        "residual": Residual(),
    }


@pytest.mark.parametrize("name", modules())
def test_every_backend_says_what_torch_says(name: str, tmp_path: Path) -> None:
    module, path = modules()[name], tmp_path / "policy.onnx"
    export(module, CONTRACT, path)
    retinas = random_retinas(CONTRACT)
    expected = torch_q_values(module, retinas).astype(np.float32)
    for backend in ("numpy", "onnxruntime"):
        q_values, actions = load_policy(path, backend).decide(retinas)
        assert within_tolerance(q_values, expected)
        assert not flips(actions, np.argmax(expected, axis=1), expected).any()


@pytest.mark.parametrize("name", PRESETS)
def test_presets_export_with_their_own_contract(name: str, tmp_path: Path) -> None:
    config, path = PRESETS[name], tmp_path / "policy.onnx"
    contract = config.contract()
    written = export(new_network(contract, config.network, 1), contract, path)
    assert load_policy(path).contract == written
    mine = {"golden": contract.golden, "q_tolerance": contract.q_tolerance}
    assert dataclasses.replace(written, **mine) == contract
    assert len(written.golden.retinas) == 16
    assert not written.golden.sequences
    assert 1e-6 <= written.q_tolerance < 5e-5


def test_a_larger_tolerance_of_the_contract_is_kept(tmp_path: Path) -> None:
    contract = dataclasses.replace(CONTRACT, q_tolerance=1e-3)
    network = new_network(CONTRACT, NetworkConfig(), 0)
    assert export(network, contract, tmp_path / "p.onnx").q_tolerance == 1e-3


def test_other_eyes_and_actions_are_exported(tmp_path: Path) -> None:
    contract = PolicyContract(
        retina=RetinaSpec(rays=5, frames=2, eyes=2, baseline_m=0.2, channels=3),
        actions=(Action("go", 1.0, 0.0), Action("turn", 1.0, 0.0, 0.5)),
    )
    export(new_network(contract, NetworkConfig(), 0), contract, tmp_path / "p.onnx")
    q_values, actions = load_policy(tmp_path / "p.onnx").decide(random_retinas(contract, 7))
    assert (q_values.shape, actions.shape) == ((7, 2), (7,))


def test_graph_is_old_enough_and_says_what_goes_in_and_out(tmp_path: Path) -> None:
    path = tmp_path / "policy.onnx"
    export(new_network(CONTRACT, NetworkConfig(), 0), CONTRACT, path)
    model = onnx.load(path)
    assert (model.ir_version, model.opset_import[0].version) == (8, 17)
    values = {v.name: v.type.tensor_type for v in [*model.graph.input, *model.graph.output]}
    assert list(values) == ["retina", "q_values", "action"]
    shapes = [[d.dim_param or d.dim_value for d in v.shape.dim] for v in values.values()]
    assert shapes == [["N", 1, 1, 16, 1], ["N", 3], ["N"]]
    kinds = [v.elem_type for v in values.values()]
    assert kinds == [onnx.TensorProto.UINT8, onnx.TensorProto.FLOAT, onnx.TensorProto.INT64]


def test_tie_takes_the_first_action_on_every_backend(tmp_path: Path) -> None:
    module = nn.Sequential(nn.Flatten(), nn.Linear(16, 3))
    nn.init.zeros_(module[1].weight)
    nn.init.zeros_(module[1].bias)
    export(module, CONTRACT, tmp_path / "p.onnx")
    for backend in ("numpy", "onnxruntime"):
        actions = load_policy(tmp_path / "p.onnx", backend).decide(random_retinas(CONTRACT))[1]
        assert not actions.any()


def test_same_module_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.onnx", "b.onnx"):
        export(new_network(CONTRACT, NetworkConfig(), 4), CONTRACT, tmp_path / name)
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()


def test_recorded_retinas_are_among_the_golden_vectors(tmp_path: Path) -> None:
    recorded = random_retinas(CONTRACT, 3)
    network = new_network(CONTRACT, NetworkConfig(), 4)
    written = export(network, CONTRACT, tmp_path / "p.onnx", recorded=recorded)
    assert written.golden.retinas[0] == tuple(recorded[0].ravel().tolist())


def test_export_leaves_the_module_as_it_was(tmp_path: Path) -> None:
    module = nn.Sequential(nn.Flatten(), nn.Linear(16, 3)).train()
    before = module[1].weight.clone()
    export(module, CONTRACT, tmp_path / "p.onnx")
    assert module.training
    assert torch.equal(module[1].weight, before)


class Branching(nn.Module):
    """Cannot be traced: what it does depends on what it sees."""

    def forward(self, x: Tensor) -> Tensor:
        return x.flatten(1)[:, :3] if x.sum() > 0 else x.flatten(1)[:, 3:6]


class TwoResults(nn.Module):
    """Returns a memory, which its contract does not have."""

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        return x.flatten(1)[:, :3], x.flatten(1)


class Huge(nn.Module):
    """Takes the difference of what float32 cannot tell apart."""

    def forward(self, x: Tensor) -> Tensor:
        return (x + 1e7) - 1e7


class Sorting(nn.Module):
    """Uses an operator that no table has."""

    def forward(self, x: Tensor) -> Tensor:
        return torch.sort(x.flatten(1)[:, :3]).values


@pytest.mark.parametrize(
    ("module", "message"),
    [
        (nn.Sequential(nn.Flatten(), nn.Linear(16, 3), nn.Softmax(0)), "over the batch"),
        (nn.Sequential(nn.Flatten(), nn.Linear(16, 3), nn.Softshrink()), "operator Softshrink"),
        (nn.Sequential(nn.Flatten(), nn.Linear(16, 3), nn.Flatten(0)), "expected Q-values"),
        (nn.Sequential(nn.Flatten(), nn.Linear(16, 4)), "expected Q-values"),
        (nn.Sequential(nn.Flatten(), nn.Linear(8, 3)), "the module fails on retinas"),
        (nn.Sequential(nn.Linear(1, 3), nn.Flatten(2, -1), nn.Flatten()), "expected Q-values"),
        (TwoResults(), r"expected Q-values .*state\.size is 0\), got 2 tensors"),
        (Branching(), "cannot be traced"),
        (Sorting(), "operator sort"),
        (
            nn.Sequential(nn.Flatten(), nn.Linear(16, 3), Huge()),
            "numbers leave when they cancel",
        ),
    ],
    ids=str,
)
def test_what_cannot_be_exported_is_refused_in_one_line(
    module: nn.Module, message: str, tmp_path: Path
) -> None:
    with pytest.raises(PolicyError, match=message) as refusal:
        export(module, CONTRACT, tmp_path / "p.onnx")
    assert "\n" not in str(refusal.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shift", [1e-5, float("nan")])
def test_disagreement_leaves_the_file_that_was_there(
    shift: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "policy.onnx"
    path.write_bytes(b"the old policy")
    honest = torch_decide

    def wrong(module: nn.Module, retinas: npt.NDArray[np.uint8], _: None) -> Any:
        q_values, actions, _ = honest(module, retinas)
        return q_values + np.float32(shift), actions, None

    monkeypatch.setattr("reflexarc_trainer.policy.export.torch_decide", wrong)
    with pytest.raises(PolicyError, match="NumPy and torch do not agree"):
        export(new_network(CONTRACT, NetworkConfig(), 0), CONTRACT, path)
    assert [p.name for p in tmp_path.iterdir()] == ["policy.onnx"]
    assert path.read_bytes() == b"the old policy"


def test_onnxruntime_that_disagrees_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def load(model: bytes, backend: str, **options: bool) -> Any:
        policy = load_policy(model, "numpy", **options)
        return policy if backend == "numpy" else dataclasses.replace(policy, graph=Shifted())

    class Shifted:
        name = "onnxruntime"

        def run(self, retinas: npt.NDArray[np.uint8], _: None) -> Any:
            count = len(retinas)
            return np.full((count, 3), 9.0, np.float32), np.zeros(count, np.int64), None

    monkeypatch.setattr(parity, "load_policy", load)
    with pytest.raises(PolicyError, match=r"onnxruntime .* and NumPy do not agree"):
        export(new_network(CONTRACT, NetworkConfig(), 0), CONTRACT, tmp_path / "p.onnx")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 3e38])
def test_module_that_is_not_finite_is_refused(value: float, tmp_path: Path) -> None:
    module = nn.Sequential(nn.Flatten(), nn.Linear(16, 3))
    nn.init.constant_(module[1].bias, value)
    nn.init.constant_(module[1].weight, abs(value))
    with pytest.raises(PolicyError, match="its values are not finite"):
        export(module, CONTRACT, tmp_path / "p.onnx")


def large_network(seed: int, gain: float) -> nn.Module:
    """Two layers of 64 units, as learners begin: orthogonal weights, the last of a gain."""
    torch.manual_seed(seed)
    layers = [nn.Linear(16, 64), nn.ReLU(), nn.Linear(64, 64), nn.ReLU(), nn.Linear(64, 3)]
    for layer, scale in zip(layers[::2], (2**0.5, 2**0.5, gain), strict=True):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(nn.Flatten(), *layers)


class OfBytes(nn.Module):
    """A network of bytes, not of numbers in [0, 1]."""

    def __init__(self, inner: nn.Module) -> None:
        super().__init__()
        self.inner = inner

    def forward(self, x: Tensor) -> Tensor:
        inner: Tensor = self.inner(x * 255.0)
        return inner


@pytest.mark.parametrize("gain", [10.0, 100.0, 1000.0])
@pytest.mark.parametrize("kind", [nn.Identity, OfBytes])
def test_large_values_are_no_reason_to_refuse(
    kind: type[nn.Module], gain: float, tmp_path: Path
) -> None:
    module = large_network(3, gain) if kind is nn.Identity else OfBytes(large_network(3, gain))
    written = export(module, CONTRACT, tmp_path / "p.onnx")
    assert written.q_tolerance > 1e-4
    load_policy(tmp_path / "p.onnx", "onnxruntime")


def test_a_file_whose_tolerance_is_too_small_is_refused_for_that(tmp_path: Path) -> None:
    path = tmp_path / "p.onnx"
    written = export(large_network(3, 1000.0), CONTRACT, path)
    other = dataclasses.replace(written, q_tolerance=1e-6)
    model = with_contract(path.read_bytes(), other)
    load_policy(model)
    with pytest.raises(PolicyError, match=r"more than the q_tolerance .* too small"):
        load_policy(model, "onnxruntime")


class Halved(nn.Module):
    """Uses numbers that float32 does not have."""

    def forward(self, x: Tensor) -> Tensor:
        return (x.flatten(1)[:, :3] * 0.1 - 0.7).float() * 1e5


def test_numbers_that_float32_does_not_have_are_rounded_and_no_reason_to_refuse(
    tmp_path: Path,
) -> None:
    written = export(Halved(), CONTRACT, tmp_path / "p.onnx")
    retinas = random_retinas(CONTRACT)
    expected = torch_q_values(Halved(), retinas).astype(np.float32)
    q_values, _ = load_policy(tmp_path / "p.onnx").decide(retinas)
    assert within_tolerance(q_values, expected, written.q_tolerance)


def test_q_values_that_cancel_out_pass_in_a_smaller_unit(tmp_path: Path) -> None:
    class Cancelling(nn.Module):
        """Large numbers whose differences are small beside them."""

        def __init__(self, unit: float) -> None:
            super().__init__()
            self.unit = unit

        def forward(self, x: Tensor) -> Tensor:
            x = torch.flatten(x, 1)[:, :3]
            return ((x * 3e3 + 3e6) - 3.0015e6) / self.unit

    with pytest.raises(PolicyError, match="in a smaller unit would pass: divide them by"):
        export(Cancelling(1.0), CONTRACT, tmp_path / "p.onnx")
    export(Cancelling(700.0), CONTRACT, tmp_path / "p.onnx")
