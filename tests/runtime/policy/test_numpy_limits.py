"""A batch is computed in parts where it would take too much at once; the bits are the same."""

import numpy as np
import pytest
from onnx import helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy import numpy_backend
from reflexarc_runtime.policy.numpy_limits import Meter
from reflexarc_runtime.policy.operators.graph_node import OnnxNode
from reflexarc_runtime.policy.policy import load_policy
from support.policies import SMALL, exported
from support.remembering import remembering_policy

RETINAS = np.random.default_rng(5).integers(0, 256, (50, *SMALL.retina.stack_shape), dtype=np.uint8)


def test_a_batch_in_parts_gives_the_bits_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    data = exported(SMALL)
    whole = load_policy(data).decide(RETINAS)
    monkeypatch.setattr(numpy_backend, "ELEMENTS_AT_ONCE", 400)
    policy = load_policy(data, verify=False)
    sizes: list[int] = []
    count = Meter.count

    def spied(self: Meter, node: OnnxNode, inputs: list[np.ndarray]) -> None:
        sizes.append(len(inputs[0]) if node.kind == "ArgMax" else 0)
        count(self, node, inputs)

    monkeypatch.setattr(Meter, "count", spied)
    for mine, its in zip(policy.decide(RETINAS), whole, strict=True):
        np.testing.assert_array_equal(mine, its)
    assert 0 < max(sizes) < 50


def test_memories_are_parted_with_the_retinas(monkeypatch: pytest.MonkeyPatch) -> None:
    data = remembering_policy()
    whole = load_policy(data)
    shape = whole.contract.retina.stack_shape
    retinas = np.random.default_rng(6).integers(0, 256, (30, *shape), dtype=np.uint8)
    size = whole.contract.state.size
    memories = np.random.default_rng(7).normal(size=(30, size)).astype(np.float32)
    expected = whole.decide(retinas, memories)
    monkeypatch.setattr(numpy_backend, "ELEMENTS_AT_ONCE", 4000)
    for mine, its in zip(load_policy(data).decide(retinas, memories), expected, strict=True):
        np.testing.assert_array_equal(mine, its)


def test_an_empty_batch_gives_empty_answers() -> None:
    q_values, actions = load_policy(exported(SMALL)).decide(RETINAS[:0])
    assert (q_values.shape, actions.shape) == ((0, 3), (0,))


def test_what_is_made_adds_up() -> None:
    node, half = OnnxNode("Relu", outputs=("y",)), np.zeros(60)
    meter = Meter(1000, 1)
    for _ in range(4):
        meter.count(node, [half])
    assert meter.made == 4 * 4 * 60
    with pytest.raises(PolicyError, match=r"node 'y' \(Relu\)"):
        meter.count(node, [half])


@pytest.mark.parametrize(
    ("kind", "inputs", "made"),
    [
        ("Mul", [(3, 1), (1, 4)], 12),
        ("MatMul", [(2, 5, 3), (3, 4)], 40),
        ("MatMul", [(3,), (3, 4)], 4),
        ("Concat", [(3, 2), (4, 2)], 14),
        ("Add", [(0, 3), (1, 3)], 0),
    ],
)
def test_a_few_costs_by_hand(kind: str, inputs: list[tuple[int, ...]], made: int) -> None:
    meter = Meter(1 << 60, 1)
    meter.count(OnnxNode(kind, outputs=("y",)), [np.zeros(shape) for shape in inputs])
    assert meter.made == made


def test_a_node_that_does_not_fit_is_left_to_numpy_to_refuse() -> None:
    node = helper.make_node("Add", ["x", "y"], ["z"])
    meter = Meter(1 << 60, 1)
    meter.count(OnnxNode(node.op_type, outputs=("z",)), [np.zeros((2, 3)), np.zeros((4, 5))])
    assert meter.made == 20
