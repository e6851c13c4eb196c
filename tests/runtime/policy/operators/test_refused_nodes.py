"""What an operator does not do as asked it refuses by name, in one line."""

from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.policy.operators.operator_table import operator_of

TEXT = helper.make_tensor("words", TensorProto.STRING, [1], ["word"])
FOUR_BITS = helper.make_tensor("small", TensorProto.INT4, [2], [1, 2])


@pytest.mark.parametrize(
    ("kind", "attributes", "said"),
    [
        ("Add", {"broadcast": 1}, "attribute broadcast"),
        ("ArgMax", {"select_last_index": 1}, "select_last_index=1"),
        ("AveragePool", {"kernel_shape": [2], "count_include_pad": 1, "ceil_mode": 1}, "ceil_mode"),
        ("BatchNormalization", {"training_mode": 1}, "training_mode=1; .*inference"),
        ("Cast", {"to": TensorProto.STRING}, "to type 8"),
        ("Concat", {}, "attribute 'axis' is missing"),
        ("Constant", {"value": TEXT}, "'words' is of type STRING"),
        ("Constant", {"value": FOUR_BITS}, "'small' is of type INT4"),
        ("Constant", {"value_string": "word"}, "value_string"),
        ("Constant", {}, "'value' is missing"),
        ("GatherND", {"batch_dims": 1}, "batch_dims=1"),
        ("Gelu", {"approximate": "sin"}, "approximate=sin"),
        ("MaxPool", {"kernel_shape": [2, 2], "strides": [1]}, "do not fit"),
        ("MaxPool", {"kernel_shape": [0]}, "do not fit"),
        ("MaxPool", {"kernel_shape": [2], "auto_pad": "SOME"}, "auto_pad=SOME"),
        ("Mod", {"fmod": 1}, "fmod=1"),
        ("Pad", {"mode": "mirror"}, "mode=mirror"),
        ("Reshape", {"allowzero": 1}, "allowzero=1"),
        ("Split", {"num_outputs": 3}, "num_outputs=3"),
        ("NonZero", {}, "is not in the NumPy backend.*--backend onnxruntime"),
    ],
)
def test_a_node_is_refused(kind: str, attributes: dict[str, Any], said: str) -> None:
    node = helper.make_node(kind, ["x"], ["y"], **attributes)
    with pytest.raises(PolicyError, match=said) as refusal:
        operator_of(node)
    assert "\n" not in str(refusal.value)


def test_an_operator_of_another_domain_is_refused_by_its_full_name() -> None:
    node = helper.make_node("Relu", ["x"], ["y"], domain="com.example")
    with pytest.raises(PolicyError, match=r"operator com\.example\.Relu"):
        operator_of(node)


def model_of(opset: int | None) -> onnx.ModelProto:
    weights = numpy_helper.from_array(np.ones(3, np.float32), "x")
    node = helper.make_node("Relu", ["x"], ["q_values"])
    graph = helper.make_graph([node], "graph", [], [], [weights])
    versions = [] if opset is None else [helper.make_opsetid("", opset)]
    return helper.make_model(graph, opset_imports=versions)


@pytest.mark.parametrize("opset", [6, 99])
def test_an_operator_set_that_is_not_known_is_refused(opset: int) -> None:
    with pytest.raises(PolicyError, match=f"of set {opset}; .* sets 7 to"):
        NumpyGraph(model_of(opset))


def test_a_top_that_is_larger_than_all_is_refused() -> None:
    top = operator_of(helper.make_node("TopK", ["x", "k"], ["values", "places"]))
    with pytest.raises(PolicyError, match="k up to 3, got 4"):
        top(np.ones(3), np.array([4]))


def test_a_window_that_fits_nowhere_is_refused() -> None:
    pool = operator_of(helper.make_node("MaxPool", ["x"], ["y"], kernel_shape=[5]))
    with pytest.raises(PolicyError, match="larger than"):
        pool(np.ones((1, 1, 3)))


def test_half_floats_are_rounded_where_they_are_cast() -> None:
    cast = operator_of(helper.make_node("Cast", ["x"], ["y"], to=TensorProto.FLOAT16))
    assert cast(np.array([0.1])).tolist() == [float(np.float16(0.1))]


@pytest.mark.parametrize("kind", [TensorProto.FLOAT16, TensorProto.BFLOAT16, TensorProto.DOUBLE])
def test_weights_of_every_width_are_computed_in_double(kind: int) -> None:
    weights = helper.make_tensor("weights", kind, [2], [0.5, -1.25])
    array = operator_of(helper.make_node("Constant", [], ["y"], value=weights))()
    assert array.dtype == np.float64
    assert array.tolist() == [0.5, -1.25]
