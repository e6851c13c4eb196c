"""The two ready networks with a memory."""

from pathlib import Path

import numpy as np
import pytest
import torch

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.recurrent_network import GruNetwork, LstmNetwork

Network = type[GruNetwork] | type[LstmNetwork]
both = pytest.mark.parametrize("network", [GruNetwork, LstmNetwork])
EYE = RetinaSpec(rays=5, frames=2, eyes=2, baseline_m=0.2, channels=3)


@both
def test_it_is_exported_for_any_eye_and_remembers(network: Network, tmp_path: Path) -> None:
    contract = PolicyContract(retina=EYE, state=network.memory(7))
    export(network(contract, 7), contract, tmp_path / "p.onnx")
    policy = load_policy(tmp_path / "p.onnx", "onnxruntime")
    retina = np.full((1, *EYE.stack_shape), 90, np.uint8)
    memory = np.zeros((1, contract.state.size), np.float32)
    first, _, memory = policy.decide(retina, memory)
    second, _, _ = policy.decide(retina, memory)
    assert not np.array_equal(first, second)


@both
def test_its_weights_come_from_its_seed_alone(network: Network) -> None:
    contract = PolicyContract(state=network.memory(4))
    torch.manual_seed(1)
    state = torch.random.get_rng_state()
    mine = network(contract, 4, seed=8)
    assert torch.equal(torch.random.get_rng_state(), state)
    torch.manual_seed(2)
    again, other = network(contract, 4, seed=8), network(contract, 4, seed=9)
    pairs = list(zip(mine.parameters(), again.parameters(), other.parameters(), strict=True))
    assert all(torch.equal(a, b) and not torch.equal(a, c) for a, b, c in pairs)


@both
def test_a_contract_with_another_memory_is_refused_in_one_line(network: Network) -> None:
    with pytest.raises(UsageError, match=r"StateSpec\(size=\d+\)") as refusal:
        network(PolicyContract(state=network.memory(4)), 5)
    assert "\n" not in str(refusal.value)
