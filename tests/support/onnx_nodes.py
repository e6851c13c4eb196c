"""One ONNX node by itself, computed by onnxruntime: the oracle of the NumPy operators."""

from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
import onnxruntime
from onnx import helper

from reflexarc_runtime.policy.operators.operator_table import operator_of

Array = npt.NDArray[Any]


def by_onnxruntime(
    node: onnx.NodeProto, inputs: list[Array | None], opset: int = 17
) -> list[Array]:
    """Every output of a node; an input that is None is not given."""
    given = [
        (name, array) for name, array in zip(node.input, inputs, strict=True) if array is not None
    ]
    kinds = {name: helper.np_dtype_to_tensor_dtype(array.dtype) for name, array in given}
    graph = helper.make_graph(
        [node],
        "node",
        [helper.make_tensor_value_info(n, kinds[n], list(a.shape)) for n, a in given],
        [helper.make_empty_tensor_value_info(n) for n in node.output],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=8)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(
        model.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
    return list(session.run(None, dict(given)))


def in_double(inputs: list[Array | None]) -> list[Array | None]:
    """What the NumPy backend is given for them: floats in double precision."""
    return [a.astype(np.float64) if a is not None and a.dtype.kind == "f" else a for a in inputs]


def by_numpy(
    node: onnx.NodeProto, inputs: list[Array | None], opset: int = 17
) -> tuple[Array, ...]:
    """The same by the function of the NumPy backend."""
    result = operator_of(node, opset)(*in_double(inputs))
    return result if isinstance(result, tuple) else (result,)
