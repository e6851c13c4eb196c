"""A model is whole and in order, or refused with a reason that a reader understands."""

from collections.abc import Callable

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.policy import load_contract, load_policy
from support.policies import SMALL, exported

POLICY = exported(SMALL)
RETINAS = np.random.default_rng(3).integers(0, 256, (20, *SMALL.retina.stack_shape), dtype=np.uint8)


def changed(change: Callable[[onnx.ModelProto], object]) -> bytes:
    model = onnx.ModelProto.FromString(POLICY)
    change(model)
    return model.SerializeToString()


def weights_as_nodes(model: onnx.ModelProto) -> None:
    for tensor in reversed(model.graph.initializer):
        model.graph.node.insert(0, helper.make_node("Constant", [], [tensor.name], value=tensor))
    del model.graph.initializer[:]


def weights_as_inputs_too(model: onnx.ModelProto) -> None:
    for tensor in model.graph.initializer:
        value = helper.make_tensor_value_info(tensor.name, tensor.data_type, tensor.dims)
        model.graph.input.append(value)


def newest_format(model: onnx.ModelProto) -> None:
    model.ir_version = 14


def training_too(model: onnx.ModelProto) -> None:
    model.training_info.add()


@pytest.mark.parametrize(
    "change", [weights_as_nodes, weights_as_inputs_too, newest_format, training_too]
)
def test_what_exporters_write_computes_the_same_bits(
    change: Callable[[onnx.ModelProto], object],
) -> None:
    got, expected = (
        load_policy(changed(change)).decide(RETINAS),
        load_policy(POLICY).decide(RETINAS),
    )
    for mine, its in zip(got, expected, strict=True):
        np.testing.assert_array_equal(mine, its)


@pytest.mark.parametrize("change", [weights_as_nodes, weights_as_inputs_too])
def test_it_runs_on_onnxruntime_too(change: Callable[[onnx.ModelProto], object]) -> None:
    actions = load_policy(changed(change), "onnxruntime").decide(RETINAS)[1]
    np.testing.assert_array_equal(actions, load_policy(POLICY).decide(RETINAS)[1])


def elsewhere(location: str, place: str) -> Callable[[onnx.ModelProto], object]:
    def change(model: onnx.ModelProto) -> None:
        tensor = model.graph.initializer[0]
        if place == "node":
            weights_as_nodes(model)
            tensor = model.graph.node[0].attribute[0].t
        if place == "function":
            tensor = model.functions.add().node.add().attribute.add().t
        if place == "branch":
            tensor = model.graph.node[0].attribute.add().g.initializer.add()
        if place == "sparse":
            tensor = model.graph.sparse_initializer.add().values
        tensor.data_location = TensorProto.EXTERNAL
        tensor.external_data.add(key="location", value=location)

    return change


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize("place", ["initializer", "node", "function", "branch", "sparse"])
def test_weights_in_another_file_are_refused_from_everywhere(place: str, backend: str) -> None:
    data = changed(elsewhere("weights.data", place))
    with pytest.raises(PolicyError, match=r"its weights lie in weights\.data; embed them"):
        load_policy(data, backend)


@pytest.mark.parametrize("location", ["/dev/zero", "../secret", "a\nb", "", "x" * 999])
def test_another_file_is_never_opened_and_named_in_one_line(location: str) -> None:
    with pytest.raises(PolicyError, match="its weights lie in") as refusal:
        load_contract(changed(elsewhere(location, "initializer")))
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 250


def reverse(model: onnx.ModelProto) -> None:
    nodes = list(model.graph.node)[::-1]
    del model.graph.node[:]
    model.graph.node.extend(nodes)


def read_nothing(model: onnx.ModelProto) -> None:
    model.graph.node[4].input[0] = "nowhere"


def make_twice(model: onnx.ModelProto) -> None:
    model.graph.node[4].output[0] = "sums"


def name_twice(model: onnx.ModelProto) -> None:
    model.graph.initializer.append(model.graph.initializer[0])


def make_no_action(model: onnx.ModelProto) -> None:
    del model.graph.node[-1]


def have_no_nodes(model: onnx.ModelProto) -> None:
    del model.graph.node[:]


def two_retinas(model: onnx.ModelProto) -> None:
    model.graph.input.append(model.graph.input[0])


def another_shape(model: onnx.ModelProto) -> None:
    model.graph.input[0].type.tensor_type.shape.dim[3].dim_value = 9


def one_row_only(model: onnx.ModelProto) -> None:
    model.graph.input[0].type.tensor_type.shape.dim[0].dim_value = 1


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (reverse, "its nodes are not in order: node 'action' ('ArgMax') reads 'q_values'"),
        (read_nothing, "reads 'nowhere', which nothing makes"),
        (make_twice, "'sums' is made twice"),
        (name_twice, "two weights are called 'scale'"),
        (make_no_action, "no node makes its output 'action'"),
        (have_no_nodes, "without a graph"),
        (two_retinas, "got retina, retina and"),
        (another_shape, "expected a retina (n, 1, 1, 4, 1) as its contract says"),
    ],
)
def test_a_model_that_is_not_in_order_is_refused(
    change: Callable[[onnx.ModelProto], object], reason: str, backend: str
) -> None:
    with pytest.raises(PolicyError) as refusal:
        load_policy(changed(change), backend)
    assert reason in str(refusal.value)


def test_a_name_that_is_no_text_is_refused() -> None:
    data = changed(lambda model: None).replace(b"hidden", b"hid\xff\xfen")
    with pytest.raises(PolicyError, match=r"no text"):
        load_policy(data)
