"""Operators of shape: the same elements, in the same places, as onnxruntime puts them."""

from typing import Any

import numpy as np
import onnx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.policy.operators import OPERATORS
from reflexarc_runtime.policy.recurrent_operators import MANY_OPERATORS
from support.onnx_nodes import Array, attributes_of, by_onnxruntime, in_double

shapes = st.lists(st.integers(1, 4), min_size=1, max_size=4)


def filled(shape: list[int]) -> Array:
    return np.arange(np.prod(shape), dtype=np.float32).reshape(shape)


def whole(*numbers: int) -> Array:
    return np.array(numbers, np.int64)


def assert_same(kind: str, inputs: list[Array | None], outputs: int = 1, **attributes: Any) -> None:
    names = [f"x{i}" if a is not None else "" for i, a in enumerate(inputs)]
    node = helper.make_node(kind, names, [f"y{i}" for i in range(outputs)], **attributes)
    expected = by_onnxruntime(node, inputs)
    if kind in MANY_OPERATORS:
        got = MANY_OPERATORS[kind](attributes_of(node), node)(*in_double(inputs))
    else:
        got = (OPERATORS[kind](attributes_of(node))(*in_double(inputs)),)
    assert [g.shape for g in got] == [e.shape for e in expected]
    for mine, its in zip(got, expected, strict=True):
        np.testing.assert_array_equal(mine, its)


@given(shape=shapes, data=st.data())
@settings(deadline=None, max_examples=40)
def test_transpose(shape: list[int], data: st.DataObject) -> None:
    axes = data.draw(st.permutations(range(len(shape))))
    assert_same("Transpose", [filled(shape)], perm=axes)
    assert_same("Transpose", [filled(shape)])


@given(shape=shapes, count=st.integers(1, 3), data=st.data())
@settings(deadline=None, max_examples=40)
def test_concat(shape: list[int], count: int, data: st.DataObject) -> None:
    axis = data.draw(st.integers(-len(shape), len(shape) - 1))
    parts: list[Array | None] = []
    for _ in range(count):
        shape[axis] = data.draw(st.integers(1, 3))
        parts.append(filled(shape))
    assert_same("Concat", parts, axis=axis)


@given(shape=shapes, data=st.data())
@settings(deadline=None, max_examples=60)
def test_split(shape: list[int], data: st.DataObject) -> None:
    axis = data.draw(st.integers(-len(shape), len(shape) - 1))
    sizes = data.draw(st.lists(st.integers(1, 3), min_size=1, max_size=3))
    shape[axis] = sum(sizes)
    assert_same("Split", [filled(shape), whole(*sizes)], len(sizes), axis=axis)
    count = data.draw(st.integers(1, 3))
    shape[axis] = count * data.draw(st.integers(1, 2))
    assert_same("Split", [filled(shape)], count, axis=axis)


@given(shape=shapes, data=st.data())
@settings(deadline=None, max_examples=60)
def test_unsqueeze_and_squeeze(shape: list[int], data: st.DataObject) -> None:
    rank = len(shape) + 1
    axis = data.draw(st.integers(-rank, rank - 1))
    assert_same("Unsqueeze", [filled(shape), whole(axis)])
    shape.insert(axis % rank, 1)
    assert_same("Squeeze", [filled(shape), whole(axis)])
    assert_same("Squeeze", [filled(shape)])


@given(shape=shapes, data=st.data())
@settings(deadline=None, max_examples=100)
def test_slice(shape: list[int], data: st.DataObject) -> None:
    ends = st.one_of(st.integers(-6, 6), st.sampled_from([2**31 - 1, -(2**31), 2**63 - 1]))
    axes = data.draw(st.lists(st.integers(0, len(shape) - 1), min_size=1, unique=True))
    starts, stops = ([data.draw(ends) for _ in axes] for _ in range(2))
    steps = [data.draw(st.sampled_from([1, 1, 2, 3])) for _ in axes]
    cuts = (whole(*starts), whole(*stops), whole(*axes))
    assert_same("Slice", [filled(shape), *cuts, whole(*steps)])
    assert_same("Slice", [filled(shape), *cuts])
    assert_same("Slice", [filled(shape), *(end[: len(shape)] for end in cuts[:2])])


def test_a_slice_backwards_is_refused() -> None:
    ends = (whole(0), whole(1), whole(0), whole(-1))
    with pytest.raises(PolicyError, match="Slice: expected steps from 1 on, got -1"):
        OPERATORS["Slice"]({})(filled([3]), *ends)


def test_a_reshape_that_may_be_of_nothing_is_refused() -> None:
    with pytest.raises(PolicyError, match="allowzero=1"):
        OPERATORS["Reshape"]({"allowzero": 1})


def test_a_node_that_says_less_than_it_must_is_refused_by_the_backend() -> None:
    node = helper.make_node("Concat", ["retina"], ["q_values"])
    model = onnx.ModelProto(graph=onnx.GraphProto(node=[node]))
    with pytest.raises(PolicyError, match="Concat: attribute 'axis' is missing"):
        NumpyGraph(model)
