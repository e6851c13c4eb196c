"""The tolerance of a policy: what float32 does is never more, and not nothing beside it."""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper
from torch import Tensor, nn

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.policy.onnxruntime_backend import OnnxruntimeGraph
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import NetworkConfig
from reflexarc_trainer.policy.export import as_exported, build_model, export
from reflexarc_trainer.policy.probes import (
    Probes,
    probe_memories,
    probe_retinas,
    reached_memories,
)
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.recurrent_network import GruNetwork, LstmNetwork
from reflexarc_trainer.policy.rounding.rounding_bound import (
    LARGEST_TOLERANCE,
    rounding_bound,
    tolerance_for,
)

KINDS = {"gru": GruNetwork, "lstm": LstmNetwork}


class OnlyMemory(nn.Module):
    """Remembers a mean of what it sees, by hand."""

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        following = state * 0.9 + x.flatten(1) * 0.1
        return torch.tanh(following[:, :3] * following[:, 3:6]), following


def network(kind: str, hidden: int, gain: float, seed: int) -> tuple[nn.Module, PolicyContract]:
    if kind in KINDS:
        contract = PolicyContract(state=KINDS[kind].memory(hidden))
        module: nn.Module = KINDS[kind](contract, hidden, seed)
    else:
        contract = PolicyContract()
        module = new_network(contract, NetworkConfig((hidden,), units=kind), seed)
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.mul_(gain)
    return module, contract


def measured(module: nn.Module, contract: PolicyContract) -> tuple[float, float, float]:
    """The bound, the tolerance, and the largest difference for inputs that it did not see."""
    model = build_model(as_exported(module), contract)
    graphs: list[Any] = [NumpyGraph(model), OnnxruntimeGraph(model.SerializeToString())]
    seen, fresh = probes_of(graphs[0], contract)
    results = [graph.run(fresh.retinas, fresh.memories) for graph in graphs]
    apart = max(
        float(np.max(np.abs(b.astype(np.float64) - a) / np.maximum(1.0, np.abs(a))))
        for a, b in zip(results[0][::2], results[1][::2], strict=True)
        if a is not None
    )
    bound = rounding_bound(model, seen)
    return bound, tolerance_for(bound), apart


def probes_of(graph: NumpyGraph, contract: PolicyContract) -> tuple[Probes, Probes]:
    retinas = probe_retinas(contract, None)
    shape = (4000, *contract.retina.stack_shape)
    fresh = np.random.default_rng(99).integers(0, 256, shape, np.uint8)
    if not contract.state.size:
        return Probes(retinas, None), Probes(fresh, None)
    reached = reached_memories(graph, contract)
    memories = [probe_memories(contract, reached, len(batch)) for batch in (retinas, fresh)]
    return Probes(retinas, memories[0]), Probes(fresh, memories[1][::-1].copy())


@given(
    kind=st.sampled_from(["sigmoid", "tanh", "relu", "gru", "lstm"]),
    hidden=st.integers(1, 24),
    gain=st.floats(0.1, 100.0),
    seed=st.integers(0, 10_000),
)
@settings(deadline=None, max_examples=60)
def test_float32_never_differs_by_more(kind: str, hidden: int, gain: float, seed: int) -> None:
    bound, _, apart = measured(*network(kind, hidden, gain, seed))
    assert apart <= bound


@pytest.mark.parametrize(
    ("kind", "hidden"),
    [(kind, hidden) for kind in ("sigmoid", "tanh", "relu", "gru", "lstm") for hidden in (8, 16)],
)
def test_it_is_at_most_a_hundred_times_what_is_measured(kind: str, hidden: int) -> None:
    bound, tolerance, apart = measured(*network(kind, hidden, 1.0, 5))
    assert bound <= 100 * apart
    assert bound <= tolerance <= max(1e-6, 1.1 * bound)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_small_ones(name: str) -> None:
    contract = PRESETS[name].contract()
    module = new_network(contract, PRESETS[name].network, 1)
    bound, tolerance, apart = measured(module, contract)
    assert apart <= bound <= tolerance < 5e-5


def test_a_memory_by_hand_has_one(tmp_path: Path) -> None:
    contract = PolicyContract(state=StateSpec(size=16))
    bound, _, apart = measured(OnlyMemory(), contract)
    assert apart <= bound < 2e-6
    assert bound <= export(OnlyMemory(), contract, tmp_path / "p.onnx").q_tolerance < 2e-6


def test_a_network_that_hardly_rounds_keeps_the_usual_tolerance(tmp_path: Path) -> None:
    module, contract = network("relu", 3, 0.1, 0)
    assert measured(module, contract)[0] < 1e-6
    assert export(module, contract, tmp_path / "p.onnx").q_tolerance == 1e-6


def test_it_is_the_largest_tolerance_at_most_and_then_measured() -> None:
    module, contract = network("gru", 24, 100.0, 0)
    bound, tolerance, apart = measured(module, contract)
    assert apart < LARGEST_TOLERANCE == tolerance < bound


def test_what_amplifies_rounding_from_tick_to_tick_is_refused(tmp_path: Path) -> None:
    class Chaotic(nn.Module):
        """The logistic map: errors double at each tick."""

        def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
            return x.flatten(1)[:, :3], (4.0 * state) * (1.0 - state)

    contract = PolicyContract(state=StateSpec(16, (float(np.float32(0.3)),) * 16))
    with pytest.raises(PolicyError, match="makes rounding grow from tick to tick"):
        export(Chaotic(), contract, tmp_path / "p.onnx")


def test_an_operator_without_a_bound_has_none() -> None:
    node = helper.make_node("CumSum", ["retina"], ["q_values"])
    model = onnx.ModelProto(graph=onnx.GraphProto(node=[node]))
    probes = Probes(np.zeros((1, 1, 1, 4, 1), np.uint8), None)
    assert rounding_bound(model, probes) == np.inf
    assert tolerance_for(np.inf) == LARGEST_TOLERANCE
