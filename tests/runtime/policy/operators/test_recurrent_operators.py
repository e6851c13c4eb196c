"""GRU and LSTM: what onnxruntime computes, and nothing that was not asked for."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.operator_table import operator_of
from support.onnx_nodes import Array, by_numpy, by_onnxruntime, in_double

GATES = {"GRU": 3, "LSTM": 4}
NAMES = ("X", "W", "R", "B", "", "initial_h", "initial_c")
small = st.integers(1, 5)


def drawn(kind: str, steps: int, n: int, inputs: int, size: int, seed: int) -> list[Array]:
    """X, W, R, B, initial_h and for an LSTM initial_c."""
    rng, rows = np.random.default_rng(seed), GATES[kind] * size
    shapes = [(steps, n, inputs), (1, rows, inputs), (1, rows, size), (1, 2 * rows)]
    shapes += [(1, n, size)] * (1 if kind == "GRU" else 2)
    return [rng.normal(size=shape).astype(np.float32) for shape in shapes]


def compute(
    kind: str, tensors: list[Array], given: int = 99, **attributes: Any
) -> tuple[tuple[Array, ...], list[Array]]:
    """By NumPy and by onnxruntime, from the first so many of the tensors."""
    inputs = [*tensors[:4], None, *tensors[4:]][:given]
    while inputs[-1] is None:
        inputs.pop()
    names = NAMES[: len(inputs)]
    outputs = ["Y", "Y_h", "Y_c"][: 2 if kind == "GRU" else 3]
    size = tensors[2].shape[2]
    node = helper.make_node(kind, names, outputs, hidden_size=size, **attributes)
    return by_numpy(node, inputs), by_onnxruntime(node, inputs)


@given(
    steps=small,
    n=small,
    inputs=small,
    size=small,
    seed=st.integers(0, 999),
    before=st.sampled_from([0, 1]),
    given_inputs=st.sampled_from([3, 4, 6]),
)
@settings(deadline=None, max_examples=60)
def test_gru_is_that_of_onnxruntime(
    steps: int, n: int, inputs: int, size: int, seed: int, before: int, given_inputs: int
) -> None:
    tensors = drawn("GRU", steps, n, inputs, size, seed)
    mine, its = compute("GRU", tensors, given_inputs, linear_before_reset=before)
    for got, expected in zip(mine, its, strict=True):
        np.testing.assert_allclose(got, expected, rtol=0, atol=2e-6)
        assert got.shape == expected.shape


@given(
    steps=small,
    n=small,
    inputs=small,
    size=small,
    seed=st.integers(0, 999),
    given_inputs=st.sampled_from([3, 4, 6, 7]),
)
@settings(deadline=None, max_examples=60)
def test_lstm_is_that_of_onnxruntime(
    steps: int, n: int, inputs: int, size: int, seed: int, given_inputs: int
) -> None:
    mine, its = compute("LSTM", drawn("LSTM", steps, n, inputs, size, seed), given_inputs)
    for got, expected in zip(mine, its, strict=True):
        np.testing.assert_allclose(got, expected, rtol=0, atol=2e-6)
        assert got.shape == expected.shape


@pytest.mark.parametrize("kind", ["GRU", "LSTM"])
def test_a_sequence_is_its_steps_one_by_one(kind: str) -> None:
    x, w, r, b, *start = in_double([*drawn(kind, 6, 3, 4, 5, 1)])
    operator = operator_of(helper.make_node(kind, [], []))
    whole, *end = operator(x, w, r, b, None, *start)
    assert x is not None
    for row, expected in zip(x, whole, strict=True):
        y, *start = operator(row[np.newaxis], w, r, b, None, *start)
        np.testing.assert_allclose(y[0], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(start, end, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("kind", "attributes", "names", "said"),
    [
        ("GRU", {"direction": "bidirectional"}, NAMES[:3], "direction=bidirectional"),
        ("LSTM", {"direction": "reverse"}, NAMES[:3], "direction=reverse"),
        ("GRU", {"layout": 1}, NAMES[:3], "layout=1"),
        ("GRU", {"activations": ["Relu", "Tanh"]}, NAMES[:3], "activations=Relu Tanh"),
        ("LSTM", {"activations": ["Sigmoid", "Tanh", "Elu"]}, NAMES[:3], "Sigmoid Tanh Elu"),
        ("LSTM", {"clip": 3.0}, NAMES[:3], "clip"),
        ("LSTM", {"input_forget": 1}, NAMES[:3], "input_forget=1"),
        ("GRU", {}, ("X", "W", "R", "B", "lengths"), "input sequence_lens"),
        ("LSTM", {}, ("X", "W", "R", "B", "", "h", "c", "P"), "input P"),
    ],
)
def test_what_it_does_not_compute_is_refused_by_name_in_one_line(
    kind: str, attributes: dict[str, Any], names: tuple[str, ...], said: str
) -> None:
    node = helper.make_node(kind, names, ["Y"], **attributes)
    with pytest.raises(PolicyError, match=f"operator {kind} .*{said}.*--backend") as refusal:
        operator_of(node)
    assert "\n" not in str(refusal.value)


def test_usual_activations_may_be_written_out() -> None:
    tensors = drawn("LSTM", 2, 2, 3, 4, 5)
    mine, its = compute("LSTM", tensors, activations=["Sigmoid", "Tanh", "Tanh"])
    np.testing.assert_allclose(mine[0], its[0], atol=2e-6)
