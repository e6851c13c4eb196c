"""The NumPy backend: computes a policy's ONNX graph in float64, for a closed list of operators.

A small network computed in float64 from float32 weights and 8-bit inputs, and rounded once to
float32, gives the same bits for any order of summation and any vector width, except at ties of the
two roundings. So it is the reference: what it computed on one machine replays on another.

A graph is compiled once into a list of steps; running it makes one NumPy call for each node.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from onnx import numpy_helper

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import PolicyError

Tensor: TypeAlias = npt.NDArray[Any]
Attributes: TypeAlias = Mapping[str, Any]
Operator: TypeAlias = Callable[..., Tensor]


@dataclass(frozen=True)
class GraphStep:
    """One node of the graph: an operator, where its inputs lie and where its output goes."""

    operator: Operator
    inputs: tuple[str, ...]
    output: str


class NumpyGraph:
    """Runs an exported policy graph with NumPy alone.

    Raises:
        PolicyError: the graph uses an operator that this backend does not have.
    """

    name = "numpy"

    def __init__(self, model: onnx.ModelProto) -> None:
        self._constants = {t.name: _constant(t) for t in model.graph.initializer}
        self._steps = [_compile(node) for node in model.graph.node]

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; stacks are (n, frames, eyes, rays, channels)."""
        values: dict[str, Tensor] = {**self._constants, "retina": retinas}
        if memories is not None:
            values["state"] = memories.astype(np.float64)
        with np.errstate(all="ignore"):  # what is not finite is a verdict, not a warning
            for step in self._steps:
                values[step.output] = step.operator(*[values[name] for name in step.inputs])
            following = values.get("state_next")
            next_memories = None if following is None else following.astype(np.float32)
            return values["q_values"].astype(np.float32), values["action"], next_memories


def supported_operators() -> tuple[str, ...]:
    """Names of the ONNX operators that the NumPy backend has."""
    return tuple(sorted(_OPERATORS))


def _constant(tensor: onnx.TensorProto) -> Tensor:
    array: Tensor = numpy_helper.to_array(tensor)
    return array.astype(np.float64) if array.dtype.kind == "f" else array


def _compile(node: onnx.NodeProto) -> GraphStep:
    if node.op_type not in _OPERATORS or node.domain not in ("", "ai.onnx"):
        raise PolicyError(
            f"operator {node.op_type} (node {node.name or node.output[0]!r}) is not in the NumPy "
            f"backend, which has {', '.join(supported_operators())}; use --backend onnxruntime"
        )
    attributes = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
    try:
        operator = _OPERATORS[node.op_type](attributes)
    except KeyError as error:
        raise PolicyError(f"operator {node.op_type}: attribute {error} is missing") from None
    return GraphStep(operator, tuple(name for name in node.input if name), node.output[0])


def _cast(attributes: Attributes) -> Operator:
    to_float = attributes["to"] in (onnx.TensorProto.FLOAT, onnx.TensorProto.DOUBLE)
    dtype = np.float64 if to_float else onnx.helper.tensor_dtype_to_np_dtype(attributes["to"])
    return lambda x: x.astype(dtype)


def _gemm(attributes: Attributes) -> Operator:
    alpha, beta = attributes.get("alpha", 1.0), attributes.get("beta", 1.0)
    transpose_a, transpose_b = attributes.get("transA", 0), attributes.get("transB", 0)

    def gemm(a: Tensor, b: Tensor, c: Tensor | float = 0.0) -> Tensor:
        product = (a.T if transpose_a else a) @ (b.T if transpose_b else b)
        return alpha * product + beta * c if (alpha, beta) != (1.0, 1.0) else product + c

    return gemm


def _flatten(attributes: Attributes) -> Operator:
    axis = attributes.get("axis", 1)
    return lambda x: x.reshape(int(np.prod(x.shape[:axis])), -1)


def _reshape(_: Attributes) -> Operator:
    def reshape(x: Tensor, shape: Tensor) -> Tensor:
        kept = [x.shape[i] if size == 0 else int(size) for i, size in enumerate(shape)]
        return x.reshape(kept)

    return reshape


def _arg_max(attributes: Attributes) -> Operator:
    """Index of the largest value, after rounding to float32 as at the output of the graph."""
    axis, keep = attributes.get("axis", 0), bool(attributes.get("keepdims", 1))
    if attributes.get("select_last_index", 0):
        raise PolicyError("operator ArgMax: select_last_index=1; a tie must take the first action")
    return lambda x: np.argmax(x.astype(np.float32), axis=axis, keepdims=keep)


def _sigmoid(x: Tensor) -> Tensor:
    tail = np.exp(-np.abs(x))
    return np.where(x >= 0.0, 1.0, tail) / (1.0 + tail)


def _softplus(x: Tensor) -> Tensor:
    return np.logaddexp(0.0, x)


def _plain(operator: Operator) -> Callable[[Attributes], Operator]:
    return lambda _: operator


_OPERATORS: dict[str, Callable[[Attributes], Operator]] = {
    "Add": _plain(np.add),
    "ArgMax": _arg_max,
    "Cast": _cast,
    "Div": _plain(np.divide),
    "Flatten": _flatten,
    "Gemm": _gemm,
    "Identity": _plain(lambda x: x),
    "MatMul": _plain(np.matmul),
    "Mul": _plain(np.multiply),
    "Relu": _plain(lambda x: np.maximum(x, 0.0)),
    "Reshape": _reshape,
    "Sigmoid": _plain(_sigmoid),
    "Softplus": _plain(_softplus),
    "Sub": _plain(np.subtract),
    "Tanh": _plain(np.tanh),
}
