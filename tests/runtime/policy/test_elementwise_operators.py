"""Operators of single elements and along axes, against onnxruntime."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from onnx import helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.elementwise_operators import ELEMENTWISE
from reflexarc_runtime.policy.operators import OPERATORS
from reflexarc_runtime.policy.reducing_operators import REDUCING
from support.onnx_nodes import Array, attributes_of, by_onnxruntime, in_double

SHAPES = arrays.array_shapes(min_dims=1, max_dims=4, max_side=4)
OF_ONE = {
    "Abs": (-9.0, 9.0),
    "Acos": (-1.0, 1.0),
    "Asin": (-1.0, 1.0),
    "Atan": (-99.0, 99.0),
    "Cos": (-9.0, 9.0),
    "Elu": (-9.0, 9.0),
    "Exp": (-9.0, 9.0),
    "Floor": (-9.0, 9.0),
    "LeakyRelu": (-9.0, 9.0),
    "Log": (1e-3, 99.0),
    "Neg": (-9.0, 9.0),
    "Sign": (-1.0, 1.0),
    "Sin": (-9.0, 9.0),
    "Sqrt": (0.0, 99.0),
}
"""Name of an operator of one number → where it is tried."""
OF_TWO = ["Equal", "Greater", "GreaterOrEqual", "Less", "LessOrEqual", "Max", "Min"]
REDUCED = ["ReduceMax", "ReduceMean", "ReduceMin"]


def floats(low: float, high: float, shape: tuple[int, ...]) -> st.SearchStrategy[Array]:
    bounds = float(np.float32(low)), float(np.float32(high))
    element = st.floats(*bounds, width=32) | st.sampled_from(bounds)
    return arrays.arrays(np.float32, shape, elements=element)


def coarse(shape: tuple[int, ...]) -> st.SearchStrategy[Array]:
    """Numbers of which many are equal."""
    return arrays.arrays(np.float32, shape, elements=st.sampled_from([-1.5, -0.0, 0.0, 0.5, 2.0]))


def broadcast_to(shape: tuple[int, ...], data: st.DataObject) -> tuple[int, ...]:
    """A shape that broadcasts to another."""
    sides = [data.draw(st.sampled_from([1, side])) for side in shape]
    return tuple(sides[data.draw(st.integers(0, len(sides) - 1)) :])


def both(kind: str, inputs: list[Array | None], **attributes: Any) -> tuple[Array, Array]:
    names = [f"x{i}" if a is not None else "" for i, a in enumerate(inputs)]
    node = helper.make_node(kind, names, ["y"], **attributes)
    (expected,) = by_onnxruntime(node, inputs)
    return OPERATORS[kind](attributes_of(node))(*in_double(inputs)), expected


def assert_same(kind: str, inputs: list[Array | None], **attributes: Any) -> None:
    got, expected = both(kind, inputs, **attributes)
    assert got.shape == expected.shape
    assert (got.dtype.kind, expected.dtype.kind) in [("f", "f"), ("b", "b"), ("i", "i")]
    np.testing.assert_allclose(got, expected, rtol=2e-6, atol=2e-6)


@pytest.mark.parametrize("kind", OF_ONE)
@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=15)
def test_of_one_number(kind: str, shape: tuple[int, ...], data: st.DataObject) -> None:
    assert_same(kind, [data.draw(floats(*OF_ONE[kind], shape))])


@pytest.mark.parametrize("kind", OF_TWO)
@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=15)
def test_of_two_numbers(kind: str, shape: tuple[int, ...], data: st.DataObject) -> None:
    other = data.draw(coarse(broadcast_to(shape, data)))
    assert_same(kind, [data.draw(coarse(shape)), other])


@pytest.mark.parametrize("kind", ["And", "Or", "Not"])
@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=10)
def test_of_truths(kind: str, shape: tuple[int, ...], data: st.DataObject) -> None:
    count = 1 if kind == "Not" else 2
    assert_same(kind, [data.draw(arrays.arrays(np.bool_, shape)) for _ in range(count)])


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=30)
def test_a_choice_takes_one_or_the_other(shape: tuple[int, ...], data: st.DataObject) -> None:
    condition = data.draw(arrays.arrays(np.bool_, broadcast_to(shape, data)))
    other = data.draw(coarse(broadcast_to(shape, data)))
    assert_same("Where", [condition, data.draw(coarse(shape)), other])


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=30)
def test_a_power(shape: tuple[int, ...], data: st.DataObject) -> None:
    base, exponent = data.draw(floats(0.0, 4.0, shape)), data.draw(floats(0.5, 3.0, ()))
    got, expected = both("Pow", [base, np.asarray(exponent)])
    np.testing.assert_allclose(got, expected, rtol=1e-5, atol=1e-6)


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=30)
def test_a_clip_may_have_one_limit_or_none(shape: tuple[int, ...], data: st.DataObject) -> None:
    limits = [data.draw(st.none() | floats(-2.0, 2.0, ())) for _ in range(2)]
    wanted = [None if limit is None else np.asarray(limit) for limit in limits]
    while wanted and wanted[-1] is None:
        wanted.pop()
    assert_same("Clip", [data.draw(coarse(shape)), *wanted])


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=30)
def test_a_remainder_has_the_sign_of_its_divisor(shape: Any, data: st.DataObject) -> None:
    numbers = data.draw(arrays.arrays(np.int64, shape, elements=st.integers(-(2**47), 2**47)))
    divisor = data.draw(st.integers(-99, 99).filter(bool))
    assert_same("Mod", [numbers, np.array(divisor)])


def test_a_remainder_of_floats_is_refused() -> None:
    with pytest.raises(PolicyError, match="Mod: fmod=1"):
        OPERATORS["Mod"]({"fmod": 1})


@pytest.mark.parametrize("kind", REDUCED)
@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=20)
def test_along_axes(kind: str, shape: tuple[int, ...], data: st.DataObject) -> None:
    axes = data.draw(st.lists(st.integers(0, len(shape) - 1), unique=True))
    given_axes = {"axes": axes} if axes else {}
    keep = data.draw(st.integers(0, 1))
    assert_same(kind, [data.draw(coarse(shape))], keepdims=keep, **given_axes)


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=40)
def test_a_sum_has_its_axes_as_an_input(shape: tuple[int, ...], data: st.DataObject) -> None:
    ends = st.integers(-len(shape), len(shape) - 1)
    axes = data.draw(st.lists(ends, unique_by=lambda axis: axis % len(shape)))
    keep, idle = data.draw(st.integers(0, 1)), data.draw(st.integers(0, 1))
    numbers = data.draw(coarse(shape))
    options = {"keepdims": keep, "noop_with_empty_axes": idle}
    assert_same("ReduceSum", [numbers, np.array(axes, np.int64)], **options)
    assert_same("ReduceSum", [numbers], **options)


@pytest.mark.parametrize("kind", ["ArgMax", "ArgMin"])
@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=20)
def test_the_place_of_an_extreme(kind: str, shape: tuple[int, ...], data: st.DataObject) -> None:
    axis, keep = data.draw(st.integers(-len(shape), len(shape) - 1)), data.draw(st.integers(0, 1))
    assert_same(kind, [data.draw(coarse(shape))], axis=axis, keepdims=keep)


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=20)
def test_a_soft_maximum(shape: tuple[int, ...], data: st.DataObject) -> None:
    axis = data.draw(st.integers(-len(shape), len(shape) - 1))
    assert_same("Softmax", [data.draw(floats(-50.0, 50.0, shape))], axis=axis)


@given(shape=SHAPES, data=st.data())
@settings(deadline=None, max_examples=40)
def test_elements_by_their_places(shape: tuple[int, ...], data: st.DataObject) -> None:
    axis = data.draw(st.integers(0, len(shape) - 1))
    numbers = np.arange(np.prod(shape), dtype=np.float32).reshape(shape)
    places = st.integers(-shape[axis], shape[axis] - 1)
    slices = data.draw(arrays.arrays(np.int64, data.draw(SHAPES), elements=places))
    assert_same("Gather", [numbers, slices], axis=axis)
    sides = [data.draw(st.integers(1, side)) for side in shape]
    sides[axis] = data.draw(st.integers(1, 5))
    each = data.draw(arrays.arrays(np.int64, tuple(sides), elements=places))
    assert_same("GatherElements", [numbers, each], axis=axis)


def test_every_operator_of_these_tables_is_tried_here() -> None:
    others = {"And", "Or", "Not", "Where", "Pow", "Clip", "Mod"}
    assert {*OF_ONE, *OF_TWO, *others} == set(ELEMENTWISE)
    along = {"ReduceSum", "ArgMax", "ArgMin", "Softmax", "Gather", "GatherElements"}
    assert {*REDUCED, *along} == set(REDUCING)
