"""Policies whose graph loops: as long as a retina says, or for ever. Only onnxruntime runs them."""

import dataclasses

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_contract

FOR_EVER = 1 << 60
_ZERO = numpy_helper.from_array(np.array([0], np.int64))
Q_VALUES = (0.1, 0.9, 0.2)


def looping(
    contract: PolicyContract, trips: int, at_intensity: int | None = None, golden_intensity: int = 0
) -> bytes:
    """A policy that makes so many trips around a loop, and then says always the same.

    Args:
        contract: of three actions; its golden vector has honest values.
        trips: how many.
        at_intensity: only where the whole retina has this intensity; by default, always.
        golden_intensity: of the retina of the golden vector; by default, it is dark.
    """
    seen = np.full(contract.retina.stack_shape, golden_intensity, np.uint8)
    golden = GoldenVectors((tuple(seen.reshape(-1).tolist()),), (Q_VALUES,), (1,))
    model = _model(contract, trips, at_intensity)
    return with_contract(model.SerializeToString(), dataclasses.replace(contract, golden=golden))


def looping_in_the_light(contract: PolicyContract, brightest: float) -> bytes:
    """A policy that loops for ever where the mean of what it sees is beyond a limit."""
    plain = looping(contract, FOR_EVER, at_intensity=0, golden_intensity=1)
    model = onnx.ModelProto.FromString(plain)
    nodes = [
        helper.make_node("ReduceMean", ["seen"], ["mean"], keepdims=0),
        helper.make_node("Greater", ["mean", "limit"], ["is_special"]),
    ]
    first, *others = model.graph.node
    kept = [node for node in others if node.op_type not in ("ReduceMin", "Equal", "And")]
    kept = [node for node in kept if list(node.output) != ["most"]]
    del model.graph.node[:]
    model.graph.node.extend([first, *nodes, *kept])
    limit = numpy_helper.from_array(np.array(brightest, np.float32), "limit")
    model.graph.initializer.append(limit)
    return with_contract(model.SerializeToString(), load_contract(plain, bounds=None))


def vast_in_darkness(contract: PolicyContract, values: int = 10**11) -> bytes:
    """A policy that asks for so many int64 where the whole retina is dark; else for one."""
    bright = looping(contract, values, at_intensity=0, golden_intensity=90)
    model = onnx.ModelProto.FromString(bright)
    at = next(place for place, node in enumerate(model.graph.node) if node.op_type == "Loop")
    del model.graph.node[at]
    for node in reversed(
        [
            helper.make_node("Add", ["count", "one_value"], ["values"]),
            helper.make_node("ConstantOfShape", ["values"], ["bulk"], value=_ZERO),
            helper.make_node("ReduceMax", ["bulk"], ["turned"], keepdims=0),
        ]
    ):
        model.graph.node.insert(at, node)
    model.graph.initializer.append(numpy_helper.from_array(np.array([1], np.int64), "one_value"))
    return with_contract(model.SerializeToString(), load_contract(bright, bounds=None))


def _model(contract: PolicyContract, trips: int, at_intensity: int | None) -> onnx.ModelProto:
    constants = {
        "trips": np.array(trips, np.int64),
        "special": np.array(0 if at_intensity is None else at_intensity, np.float32),
        "yes": np.array(True),
        "none": np.array(0, np.int64),
        "nothing": np.array(0.0, np.float32),
        "said": np.array([Q_VALUES], np.float32),
    }
    least, most = ("least", "most") if at_intensity is not None else ("special", "special")
    nodes = [
        helper.make_node("Cast", ["retina"], ["seen"], to=TensorProto.FLOAT),
        helper.make_node("ReduceMin", ["seen"], ["least"], keepdims=0),
        helper.make_node("ReduceMax", ["seen"], ["most"], keepdims=0),
        helper.make_node("Equal", [least, "special"], ["all_at_least"]),
        helper.make_node("Equal", [most, "special"], ["all_at_most"]),
        helper.make_node("And", ["all_at_least", "all_at_most"], ["is_special"]),
        helper.make_node("Where", ["is_special", "trips", "none"], ["count"]),
        helper.make_node("Loop", ["count", "yes", "none"], ["turned"], body=_turn()),
        helper.make_node("Cast", ["turned"], ["turned_float"], to=TensorProto.FLOAT),
        helper.make_node("Mul", ["turned_float", "nothing"], ["zero"]),
        helper.make_node("Flatten", ["seen"], ["flat"], axis=1),
        helper.make_node("ReduceMax", ["flat"], ["column"], axes=[1], keepdims=1),
        helper.make_node("Mul", ["column", "nothing"], ["zeros"]),
        helper.make_node("Add", ["said", "zero"], ["row"]),
        helper.make_node("Add", ["row", "zeros"], ["q_values"]),
        helper.make_node("ArgMax", ["q_values"], ["action"], axis=1, keepdims=0),
    ]
    retina = ["N", *contract.retina.stack_shape]
    graph = helper.make_graph(
        nodes,
        "looping",
        [helper.make_tensor_value_info("retina", TensorProto.UINT8, retina)],
        [
            helper.make_tensor_value_info("q_values", TensorProto.FLOAT, ["N", len(Q_VALUES)]),
            helper.make_tensor_value_info("action", TensorProto.INT64, ["N"]),
        ],
        [numpy_helper.from_array(array, name) for name, array in constants.items()],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)


def _turn() -> onnx.GraphProto:
    """One trip: counts it, and goes on."""
    return helper.make_graph(
        [
            helper.make_node("Identity", ["go"], ["go_on"]),
            helper.make_node("Add", ["turns", "one"], ["more"]),
        ],
        "turn",
        [
            helper.make_tensor_value_info("trip", TensorProto.INT64, []),
            helper.make_tensor_value_info("go", TensorProto.BOOL, []),
            helper.make_tensor_value_info("turns", TensorProto.INT64, []),
        ],
        [
            helper.make_tensor_value_info("go_on", TensorProto.BOOL, []),
            helper.make_tensor_value_info("more", TensorProto.INT64, []),
        ],
        [numpy_helper.from_array(np.array(1, np.int64), "one")],
    )
