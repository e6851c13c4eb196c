"""Policies that were made to harm: each asks for more memory or time than there is, or lies.

All have a contract and one golden vector. What their graphs do beside is given in `POLICIES`.
"""

import dataclasses
import json
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from reflexarc_runtime.contract.contract import METADATA_KEY
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.contract.text import seal
from support.looping_policies import FOR_EVER, Q_VALUES, looping
from support.policies import SMALL, exported

Constants = dict[str, Any]
Nodes = Sequence[onnx.NodeProto]

GOLDEN = GoldenVectors(((0,) * SMALL.retina.size,), (Q_VALUES,), (1,))
BILLION = 10**9
node = helper.make_node


def ints(*numbers: int) -> Any:
    """Whole numbers, as an input that says a shape."""
    return np.array(numbers, np.int64)


def zeros(*shape: int) -> Any:
    """A constant of so many numbers."""
    return np.zeros(shape, np.float32)


def policy(nodes: Nodes, opset: int = 17, **constants: Any) -> bytes:
    """A policy that says always the same, after its nodes have made a value `bomb`."""
    given = {"nothing": np.array(0.0, np.float32), "said": np.array([Q_VALUES], np.float32)}
    axes = {"axes": [1]} if opset < 18 else {}
    more = [] if opset < 18 else ["one_axis"]
    around = [
        node("Cast", ["retina"], ["seen"], to=TensorProto.FLOAT),
        node("Flatten", ["seen"], ["flat"], axis=1),
        node("ReduceMax", ["flat", *more], ["column"], keepdims=1, **axes),
        node("Mul", ["column", "nothing"], ["zeros"]),
        *nodes,
        node("Cast", ["bomb"], ["bomb_float"], to=TensorProto.FLOAT),
        node("ReduceMax", ["bomb_float"], ["most"], keepdims=0),
        node("Mul", ["most", "nothing"], ["zero"]),
        node("Add", ["said", "zeros"], ["row"]),
        node("Add", ["row", "zero"], ["q_values"]),
        node("ArgMax", ["q_values"], ["action"], axis=1, keepdims=0),
    ]
    if more:
        given["one_axis"] = ints(1)
    return _sealed(model_of(around, opset, **given, **constants))


def model_of(nodes: Nodes, opset: int = 17, **constants: Any) -> onnx.ModelProto:
    """A model with the inputs and outputs of a small policy."""
    retina = ["N", *SMALL.retina.stack_shape]
    weights = [
        array if isinstance(array, onnx.TensorProto) else numpy_helper.from_array(array, name)
        for name, array in constants.items()
    ]
    graph = helper.make_graph(
        nodes,
        "hostile",
        [helper.make_tensor_value_info("retina", TensorProto.UINT8, retina)],
        [
            helper.make_tensor_value_info("q_values", TensorProto.FLOAT, ["N", 3]),
            helper.make_tensor_value_info("action", TensorProto.INT64, ["N"]),
        ],
        weights,
    )
    version = helper.make_opsetid("", opset)
    return helper.make_model(graph, opset_imports=[version], ir_version=8)


def _sealed(model: onnx.ModelProto) -> bytes:
    contract = dataclasses.replace(SMALL, golden=GOLDEN)
    helper.set_model_props(model, {METADATA_KEY: contract.to_json()})
    return model.SerializeToString()


def one(kind: str, inputs: Sequence[str], **more: Any) -> Callable[[], bytes]:
    """A policy with one node more; what is no array is an attribute of it."""
    arrays = (np.ndarray, onnx.TensorProto)
    opset = more.pop("opset", 17)
    constants = {name: value for name, value in more.items() if isinstance(value, arrays)}
    attributes = {name: value for name, value in more.items() if name not in constants}
    return lambda: policy([node(kind, inputs, ["bomb"], **attributes)], opset, **constants)


def _chain(kind: str, count: int, inputs: int = 1, start: str = "column") -> Callable[[], bytes]:
    """Many nodes, each of which reads the one before, so often."""

    def make() -> bytes:
        names = [start, *[f"v{i}" for i in range(count - 1)], "bomb"]
        how = {"axis": 0} if kind == "Concat" else {}
        pairs = pairwise(names)
        return policy([node(kind, [a] * inputs, [b], **how) for a, b in pairs])

    return make


def _by_what_is_seen() -> bytes:
    """Small for the dark golden retina, 10⁹ numbers for a bright one."""
    nodes = [
        node("ReduceMax", ["seen"], ["brightest"], keepdims=0),
        node("Mul", ["brightest", "many"], ["wanted"]),
        node("Cast", ["wanted"], ["count"], to=TensorProto.INT64),
        node("Add", ["count", "first"], ["sides"]),
        node("ConstantOfShape", ["sides"], ["bomb"]),
    ]
    return policy(nodes, many=np.array(4e6, np.float32), first=ints(1))


def _products() -> bytes:
    names = ["w", *[f"v{i}" for i in range(99)], "bomb"]
    pairs = pairwise(names)
    return policy([node("MatMul", [a, "w"], [b]) for a, b in pairs], w=zeros(1000, 1000))


def _reductions() -> bytes:
    many = [node("ReduceMax", ["w"], [f"v{i}"], keepdims=0) for i in range(8000)]
    return policy([*many, node("Identity", ["v0"], ["bomb"])], w=zeros(4_000_000))


def _steps() -> bytes:
    names = ["x", "w", "r"]
    rnn = node("GRU", names, ["all", "bomb"], hidden_size=1)
    return policy([rnn], x=zeros(2_000_000, 1, 1), w=zeros(1, 3, 1), r=zeros(1, 3, 1))


def _functions() -> bytes:
    """Each calls the one before twice: 2³⁰ nodes when they are unfolded."""
    model = onnx.ModelProto.FromString(_chain("Identity", 1)())
    versions = [helper.make_opsetid("", 17), helper.make_opsetid("own", 1)]
    for level in range(30):
        kind, domain = (f"f{level - 1}", "own") if level else ("Identity", "")
        calls = [node(kind, [a], [b], domain=domain) for a, b in (("x", "m"), ("m", "y"))]
        model.functions.append(
            helper.make_function("own", f"f{level}", ["x"], ["y"], calls, versions)
        )
    model.opset_import.append(versions[1])
    found = next(n for n in model.graph.node if n.output[0] == "bomb")
    found.op_type, found.domain = "f29", "own"
    return model.SerializeToString()


def _nested() -> bytes:
    """A graph within a graph, so deep that parsers give up."""
    branch = helper.make_graph([], "leaf", [], [])
    for _ in range(60):
        inner = node("If", ["yes"], ["out"], then_branch=branch, else_branch=branch)
        branch = helper.make_graph([inner], "branch", [], [])
        if branch.ByteSize() > 1 << 20:
            break
    return policy([node("If", ["yes"], ["bomb"], then_branch=branch)], yes=np.array(True))


def _random(shape: list[int]) -> Callable[[], bytes]:
    return one("RandomNormal", [], shape=shape)


def _tensor(kind: int, dims: Sequence[int], **fields: Any) -> Callable[[], bytes]:
    """A policy with a tensor that is put together by hand."""
    tensor = onnx.TensorProto(name="w", data_type=kind, dims=dims, **fields)
    return lambda: policy([node("Identity", ["w"], ["bomb"])], w=tensor)


def _external(location: str) -> Callable[[], bytes]:
    entry = onnx.StringStringEntryProto(key="location", value=location)
    where = onnx.TensorProto.EXTERNAL
    return _tensor(TensorProto.FLOAT, [4], external_data=[entry], data_location=where)


def _sparse() -> bytes:
    model = onnx.ModelProto.FromString(_chain("Identity", 1)())
    values = helper.make_tensor("w", TensorProto.FLOAT, [1], [1.0])
    places = helper.make_tensor("places", TensorProto.INT64, [1], [0])
    model.graph.sparse_initializer.append(helper.make_sparse_tensor(values, places, [10**12]))
    return model.SerializeToString()


def _changed(change: Callable[[onnx.ModelProto], object]) -> Callable[[], bytes]:
    def make() -> bytes:
        model = onnx.ModelProto.FromString(exported(SMALL))
        change(model)
        return model.SerializeToString()

    return make


def _field(number: int, payload: bytes) -> bytes:
    """A field of a message on the wire."""
    size, head = len(payload), [number << 3 | 2]
    while size > 127:
        head.append(size & 127 | 128)
        size >>= 7
    return bytes([*head, size]) + payload


def _empty_parts(number: int, count: int) -> Callable[[], bytes]:
    """So many empty messages in the graph, two bytes each."""
    return lambda: exported(SMALL) + _field(7, bytes([number << 3 | 2, 0]) * count)


def _contract(change: Callable[[dict[str, Any]], object]) -> Callable[[], bytes]:
    """A contract whose fields are changed, and sealed again."""

    def make() -> bytes:
        model = onnx.ModelProto.FromString(exported(SMALL))
        document = json.loads(model.metadata_props[0].value)
        del document["digest"]
        change(document)
        model.metadata_props[0].value = seal(document)
        return model.SerializeToString()

    return make


def _text(text: Callable[[], str]) -> Callable[[], bytes]:
    """Another text in place of a contract."""

    def make() -> bytes:
        model = onnx.ModelProto.FromString(exported(SMALL))
        model.metadata_props[0].value = text()
        return model.SerializeToString()

    return make


def _many_vectors(document: dict[str, Any]) -> None:
    golden, count = document["golden"], 50_000
    for name in ("retinas", "q_values", "actions"):
        golden[name] = golden[name][:1] * count


def _add_metadata(model: onnx.ModelProto) -> None:
    model.metadata_props.add(key="note", value="x" * (100 << 20))


def _rename(model: onnx.ModelProto) -> None:
    hidden = "hid\n\x1b[31m[bold]" * 1000
    for each in model.graph.node:
        for names in (each.input, each.output):
            names[:] = [hidden if name == "hidden" else name for name in names]
    model.graph.node[4].op_type = "\x1b]0;title\x07\n"


def _nan_weights(model: onnx.ModelProto) -> None:
    for tensor in model.graph.initializer:
        array = numpy_helper.to_array(tensor)
        tensor.CopyFrom(numpy_helper.from_array(array * np.float32("nan"), tensor.name))


def _flag(model: onnx.ModelProto) -> None:
    model.graph.input[0].type.tensor_type.elem_type = TensorProto.FLOAT


def _many_inputs(model: onnx.ModelProto) -> None:
    for number in range(20_000):
        model.graph.input.add(name=f"input{number}")


LONG = zeros(20_000)
POLICIES: dict[str, Callable[[], bytes]] = {
    "an outer product": one("Mul", ["w", "c"], w=LONG, c=zeros(20_000, 1)),
    "a choice between rows and columns": one(
        "Where", ["yes", "w", "c"], yes=np.array(True), w=LONG, c=zeros(20_000, 1)
    ),
    "a matrix product of a column and a row": one(
        "MatMul", ["c", "r"], c=zeros(20_000, 1), r=zeros(1, 20_000)
    ),
    "a Gemm of a column and a row": one("Gemm", ["c", "r"], c=zeros(20_000, 1), r=zeros(1, 20_000)),
    "a Gemm with a bias of many rows": one(
        "Gemm", ["c", "r", "b"], c=zeros(1, 1), r=zeros(1, 20_000), b=zeros(20_000, 1)
    ),
    "an Einsum that makes all pairs": one("Einsum", ["w", "w"], w=LONG, equation="i,j->ij"),
    "an Einsum of five loops": one("Einsum", ["w"] * 5, w=zeros(300), equation="a,b,c,d,e->"),
    "an Einsum with an ellipsis": one(
        "Einsum", ["c", "r"], c=zeros(20_000, 1), r=zeros(1, 20_000), equation="...,..."
    ),
    "a shape of 10⁹": one("ConstantOfShape", ["s"], s=ints(BILLION)),
    "a shape of 2⁶²": one("ConstantOfShape", ["s"], s=ints(1 << 31, 1 << 31)),
    "a shape below zero": one("ConstantOfShape", ["s"], s=ints(-5)),
    "a shape of eighty sides": one("ConstantOfShape", ["s"], s=ints(*[1] * 80)),
    "an expansion": one("Expand", ["column", "s"], s=ints(BILLION, 1)),
    "a repetition": one("Tile", ["column", "s"], s=ints(30_000, 30_000)),
    "padding": one("Pad", ["column", "s"], s=ints(0, 0, 0, BILLION)),
    "padding of an axis": one(
        "Pad", ["column", "s", "", "a"], s=ints(0, BILLION), a=ints(1), opset=18
    ),
    "a range": one("Range", ["a", "b", "c"], a=np.array(0), b=np.array(1 << 40), c=np.array(1)),
    "a range by steps of 0": one(
        "Range", ["a", "b", "c"], a=np.array(0), b=np.array(9), c=np.array(0)
    ),
    "a choice of 10⁹": one("OneHot", ["p", "d", "v"], p=ints(1), d=np.array(BILLION), v=zeros(2)),
    "rows taken thousands of times": one(
        "Gather", ["w", "p"], w=zeros(2, 20_000), p=np.zeros(20_000, np.int64)
    ),
    "parts taken thousands of times": one(
        "GatherND", ["w", "p"], w=zeros(2, 20_000), p=np.zeros((20_000, 1), np.int64)
    ),
    "a norm scaled by rows": one("LayerNormalization", ["c", "w"], c=zeros(20_000, 1), w=LONG),
    "a batch norm of too many channels": one(
        "BatchNormalization", ["x", *["w"] * 4], x=zeros(1, 1, 20_000), w=LONG
    ),
    "a slope for all pairs": one("PRelu", ["c", "w"], c=zeros(20_000, 1), w=LONG),
    "a largest of all pairs": one("Max", ["c", "w", "w"], c=zeros(20_000, 1), w=LONG),
    "a convolution with wide padding": one(
        "Conv", ["x", "k"], x=zeros(1, 1, 4, 4), k=zeros(1, 1, 1, 1), pads=[30_000] * 4
    ),
    "a convolution of large windows": one(
        "Conv", ["x", "k"], x=zeros(1, 1, 1000, 1000), k=zeros(1, 1, 400, 400)
    ),
    "a pool of large windows": one(
        "AveragePool", ["x"], x=zeros(1, 1, 1000, 1000), kernel_shape=[500, 500]
    ),
    "a pool with a window of 10⁹": one("MaxPool", ["x"], x=zeros(1, 1, 9), kernel_shape=[BILLION]),
    "a resize": one(
        "Resize", ["x", "", "s"], x=zeros(1, 1, 9), s=np.array([1, 1, 1e8], np.float32)
    ),
    "an upsampling": one(
        "Upsample", ["x", "s"], x=zeros(1, 9), s=np.array([1e4, 1e4], np.float32), opset=9
    ),
    "random numbers": _random([BILLION]),
    "more sides than an array can have": one("Reshape", ["column", "s"], s=ints(-1, *[1] * 80)),
    "a shape by what is seen": _by_what_is_seen,
    "doubled forty times": _chain("Concat", 40, inputs=2),
    "added to itself for ever": _chain("Add", 9000, inputs=2),
    "many matrix products": _products,
    "many sums of many numbers": _reductions,
    "two million steps of a GRU": _steps,
    "a loop for ever": lambda: looping(SMALL, FOR_EVER),
    "a loop of 2⁶²": lambda: looping(SMALL, 1 << 62),
    "functions that call each other": _functions,
    "graphs within graphs": _nested,
    "a hundred thousand nodes": _chain("Identity", 100_000),
    "ten million empty nodes": _empty_parts(1, 10_000_000),
    "ten million empty weights": _empty_parts(5, 10_000_000),
    "twenty thousand inputs": _changed(_many_inputs),
    "weights of 10¹² without any": _tensor(TensorProto.FLOAT, [10**12]),
    "weights with a side below zero": _tensor(TensorProto.FLOAT, [-4]),
    "weights with too few bytes": _tensor(TensorProto.FLOAT, [4], raw_data=b"12"),
    "weights of no type": _tensor(0, [1], raw_data=b"1234"),
    "weights that are words": _tensor(TensorProto.STRING, [1], string_data=[b"word"]),
    "whole numbers that unfold": _tensor(
        TensorProto.INT64, [20_000_000], int64_data=np.zeros(20_000_000, np.int64)
    ),
    "weights that are mostly nothing": _sparse,
    "weights in /etc/passwd": _external("/etc/passwd"),
    "weights in /dev/zero": _external("/dev/zero"),
    "weights in a folder above": _external("../../secret"),
    "weights in a name that rings": _external("\x1b]0;\x07\n" * 99),
    "weights that are no numbers": _changed(_nan_weights),
    "names of several lines": _changed(_rename),
    "a retina of floats": _changed(_flag),
    "100 MiB of metadata": _changed(_add_metadata),
    "a contract of 60 MiB": _text(lambda: '{"a":"' + "x" * (60 << 20) + '"}'),
    "a contract of ten million lists": _text(lambda: "[" + "[]," * 10_000_000 + "0]"),
    "a contract of a hundred thousand depths": _text(lambda: "[" * 100_000),
    "a contract of ten million numbers": _text(lambda: "[" + "0," * 10_000_000 + "0]"),
    "a number of a million digits": _text(lambda: '{"schema":' + "9" * 1_000_000 + "}"),
    "fifty thousand golden vectors": _contract(_many_vectors),
    "a memory of 10⁹": _contract(lambda d: d["state"].update(size=BILLION)),
    "a hundred thousand actions": _contract(lambda d: d.update(actions=d["actions"] * 33_000)),
    "an endless rate": _contract(lambda d: d.update(rate_hz=1e308)),
}
"""What each asks for → what makes its bytes."""
