"""Running errors of activations, windows and products: onnxruntime never differs by more.

Its inputs are disturbed by what is known of them: by nothing, a little, or a lot.
"""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper

from reflexarc_runtime.policy.operators.operator_table import operator_of
from reflexarc_trainer.policy.rounding import activation_errors as activations
from reflexarc_trainer.policy.rounding import window_errors as windows
from reflexarc_trainer.policy.rounding.running_error import Running, exactly
from support.onnx_nodes import by_onnxruntime

disturbances = st.sampled_from([0.0, 1e-6, 1e-3, 0.3])
seeds = st.integers(0, 10**6)
each = settings(deadline=None, max_examples=30)


def erf(_: dict[str, Any], x: Running) -> Running:
    operator = operator_of(helper.make_node("Erf", ["x"], ["y"]))
    return activations.error_function(x, operator(x.value))


ACTIVATIONS: dict[str, tuple[dict[str, Any], Any]] = {
    "LeakyRelu": ({"alpha": 0.2}, activations.leaky_relu),
    "LeakyRelu, steeper": ({"alpha": -3.0}, activations.leaky_relu),
    "Elu": ({"alpha": 1.7}, activations.elu),
    "Softplus": ({}, lambda _, x: activations.softplus(x)),
    "Erf": ({}, erf),
    "Softmax": ({"axis": 1}, activations.soft_max),
    "Softmax of the last": ({"axis": -1}, activations.soft_max),
}
POOLS: dict[str, tuple[dict[str, Any], Any]] = {
    "MaxPool": ({"kernel_shape": [3], "strides": [2], "pads": [1, 1]}, windows.largest),
    "AveragePool": ({"kernel_shape": [3], "strides": [2], "pads": [1, 1]}, windows.mean),
    "AveragePool with its padding": (
        {"kernel_shape": [4], "pads": [2, 1], "count_include_pad": 1},
        windows.mean,
    ),
}


def disturbed(seed: int, share: float, *shape: int) -> tuple[Any, Running]:
    """Float32 values, of sizes from tiny to large, and those that they stand for."""
    rng = np.random.default_rng(seed)
    exact = rng.normal(size=shape) * 10.0 ** rng.uniform(-2.0, 2.0, shape)
    exact = exact.astype(np.float32).astype(np.float64)
    seen = (exact + share * np.abs(exact) * rng.uniform(-1.0, 1.0, shape)).astype(np.float32)
    return seen, Running(exact, np.abs(seen - exact))


def assert_holds(seen: Any, running: Running) -> None:
    off = np.abs(seen.astype(np.float64) - running.value)
    assert np.all(off <= running.error), (off - running.error).max()


@pytest.mark.parametrize("name", ACTIVATIONS)
@given(seed=seeds, share=disturbances)
@each
def test_an_activation(name: str, seed: int, share: float) -> None:
    attributes, rule = ACTIVATIONS[name]
    node = helper.make_node(name.partition(",")[0].partition(" ")[0], ["x"], ["y"], **attributes)
    seen, running = disturbed(seed, share, 6, 5)
    as_read = {a.name: helper.get_attribute_value(a) for a in node.attribute}  # in float32
    assert_holds(by_onnxruntime(node, [seen])[0], rule(as_read, running))


@pytest.mark.parametrize("name", POOLS)
@given(seed=seeds, share=disturbances)
@each
def test_a_pool(name: str, seed: int, share: float) -> None:
    attributes, rule = POOLS[name]
    node = helper.make_node(name.partition(" ")[0], ["x"], ["y"], **attributes)
    seen, running = disturbed(seed, share, 2, 3, 9)
    known = rule(operator_of(node), attributes, running)
    assert_holds(by_onnxruntime(node, [seen])[0], known)


@given(seed=seeds, share=disturbances, groups=st.sampled_from([1, 2]), has_bias=st.booleans())
@each
def test_a_convolution(seed: int, share: float, groups: int, has_bias: bool) -> None:
    attributes = {"pads": [1, 2], "strides": [2], "dilations": [2], "group": groups}
    seen, running = disturbed(seed, share, 2, 4, 11)
    weights, _ = disturbed(seed + 1, 0.0, 6, 4 // groups, 3)
    constants = [weights, disturbed(seed + 2, 0.0, 6)[0]][: 1 + has_bias]
    names = ["x", "w", "b"][: 1 + len(constants)]
    node = helper.make_node("Conv", names, ["y"], **attributes)
    known = windows.convolution(operator_of(node), attributes, running, *map(exactly, constants))
    assert_holds(by_onnxruntime(node, [seen, *constants])[0], known)


@given(seed=seeds, share=disturbances)
@each
def test_a_product_of_two_that_were_computed(seed: int, share: float) -> None:
    (a, left), (b, right) = disturbed(seed, share, 3, 4, 7), disturbed(seed + 1, share, 3, 7, 5)
    node = helper.make_node("MatMul", ["a", "b"], ["y"])
    assert_holds(by_onnxruntime(node, [a, b])[0], windows.product(left, right))


def test_a_convolution_with_computed_weights_has_no_bound() -> None:
    _, x = disturbed(1, 0.1, 1, 2, 5)
    _, w = disturbed(2, 0.1, 3, 2, 3)
    node = helper.make_node("Conv", ["x", "w"], ["y"])
    assert np.isinf(windows.convolution(operator_of(node), {}, x, w).error).all()
