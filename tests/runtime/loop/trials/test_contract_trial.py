"""What somebody answers who was asked for a policy is read in a process of its own."""

from dataclasses import replace

import pytest

from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.errors import ContractError, PolicyError
from reflexarc_runtime.loop.trials.contract_trial import tried_contract
from support.policies import exported

CONTRACT = PolicyContract(retina=RetinaSpec(rays=9, range_m=2.5), max_input_age_s=0.3)


def test_a_contract_comes_back_as_it_was_but_for_what_no_body_needs():
    contract = tried_contract(exported(CONTRACT), Bounds())
    assert contract == replace(CONTRACT, golden=GoldenVectors())


@pytest.mark.parametrize("data", [b"", b"garbage", bytes(1 << 20)])
def test_bytes_that_are_no_policy_are_refused(data: bytes):
    with pytest.raises(PolicyError, match="expected an ONNX model"):
        tried_contract(data, Bounds())


def test_bounds_hold():
    with pytest.raises(ContractError, match="--max-speed-mps"):
        tried_contract(exported(replace(CONTRACT, actions=sideways_actions(30.0))), Bounds())


def test_a_file_that_unfolds_to_gigabytes_ends_its_process_and_not_this_one():
    # 8 million empty nodes: an ONNX graph of 16 MB, which is as large as the bus lets through.
    nodes = b"\x0a\x00" * (8 << 20)
    size, length = len(nodes), b""
    while size:
        length += bytes([(size & 127) | (128 if size > 127 else 0)])
        size >>= 7
    with pytest.raises(PolicyError):
        tried_contract(b"\x3a" + length + nodes, Bounds(), loading_s=2.0)
