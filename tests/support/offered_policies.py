"""Policies that are offered to a running loop: those that fit, and those that must be refused."""

from dataclasses import dataclass, replace

import numpy as np
import onnx
from onnx import helper, numpy_helper

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.loop.candidates.swap_desk import MAX_POLICY_BYTES
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_contract
from support.hostile_policies import POLICIES
from support.looping_policies import looping_in_the_light
from support.policies import exported, network
from support.swapped_drives import fails_in_the_light

LAYERS, UNITS = 2000, 5
"""Of the slow one: functions one behind the other, of so many values each."""


@dataclass(frozen=True)
class Offer:
    """A policy, and what must become of it."""

    kind: str
    policy: bytes
    refused_for: str = ""
    """Words of the refusal; empty: it is taken, whatever happens to it later."""


def fitting(contract: PolicyContract) -> tuple[Offer, Offer]:
    """Two of one contract: the second one holds its actions."""
    holding = replace(contract, hold_s=0.1, margin=0.1)
    return (
        Offer("fits", exported(contract, seed=1)),
        Offer("fits", exported(holding, seed=2)),
    )


def failing(contract: PolicyContract, brightest: float) -> Offer:
    """One that gives no number as soon as what it sees is brighter than this, in the mean."""
    return Offer("gives NaN later", fails_in_the_light(contract, 3, brightest))


def hanging(contract: PolicyContract, brightest: float) -> Offer:
    """One that loops for ever as soon as what it sees is brighter; only onnxruntime runs it."""
    return Offer("hangs later", looping_in_the_light(contract, brightest))


def refused(contract: PolicyContract) -> list[Offer]:
    """What a loop of this contract must not take."""
    whole = exported(contract, seed=4)
    other_eye = replace(contract, retina=replace(contract.retina, range_m=7.0))
    return [
        Offer("another eye", exported(other_eye, seed=4), "eye:"),
        Offer("too large", bytes(MAX_POLICY_BYTES + 1), "at most 1000 kB"),
        Offer("hostile", next(iter(POLICIES.values()))(), "policy"),
        Offer("truncated", whole[: len(whole) // 2], "policy"),
        Offer("slow", slow(contract), "expected a "),
        Offer("no policy", b"once upon a time", "policy"),
    ]


def slow(contract: PolicyContract) -> bytes:
    """One that says what a quick one does, and computes an error function 2,000 times beside it."""
    model = onnx.ModelProto.FromString(network(contract, seed=5))
    choice = model.graph.node.pop()
    model.graph.node[-1].output[0] = "plain"
    chain = [
        helper.make_node("Erf", [f"turned{layer}" if layer else "hidden"], [f"turned{layer + 1}"])
        for layer in range(LAYERS)
    ]
    nothing = np.zeros((UNITS, len(contract.actions)), np.float32)
    model.graph.initializer.append(numpy_helper.from_array(nothing, "nothing"))
    zero = helper.make_node("MatMul", [f"turned{LAYERS}", "nothing"], ["zero"])
    both = helper.make_node("Add", ["plain", "zero"], ["q_values"])
    model.graph.node.extend([*chain, zero, both, choice])
    golden = load_contract(exported(contract, seed=5), bounds=None).golden
    return with_contract(model.SerializeToString(), replace(contract, golden=golden))
