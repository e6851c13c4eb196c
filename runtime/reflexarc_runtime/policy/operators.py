"""The ONNX operators of one output that the NumPy backend has.

The table names a maker for each: it is given the attributes of a node and returns the function
that computes it. Meanings are those of the ONNX specification, operator set 17.
"""

from collections.abc import Callable

import numpy as np
import onnx

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.elementwise_operators import ELEMENTWISE
from reflexarc_runtime.policy.operator import Attributes, Operator, Tensor, plain
from reflexarc_runtime.policy.reducing_operators import REDUCING


def sigmoid(x: Tensor) -> Tensor:
    """1 / (1 + e⁻ˣ), without overflow on either side."""
    tail = np.exp(-np.abs(x))
    return np.where(x >= 0.0, 1.0, tail) / (1.0 + tail)


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


def _reshape(attributes: Attributes) -> Operator:
    if attributes.get("allowzero", 0):
        raise PolicyError("operator Reshape: allowzero=1; a 0 must keep the size that is there")

    def reshape(x: Tensor, shape: Tensor) -> Tensor:
        kept = [x.shape[i] if size == 0 else int(size) for i, size in enumerate(shape)]
        return x.reshape(kept)

    return reshape


def _concat(attributes: Attributes) -> Operator:
    axis = attributes["axis"]
    return lambda *parts: np.concatenate(parts, axis)


def _transpose(attributes: Attributes) -> Operator:
    axes = attributes.get("perm")
    return lambda x: np.transpose(x, axes)


def _slice(
    x: Tensor, starts: Tensor, ends: Tensor, axes: Tensor | None = None, steps: Tensor | None = None
) -> Tensor:
    picked = [slice(None)] * x.ndim
    axes = np.arange(len(starts)) if axes is None else axes
    steps = np.ones(len(starts), np.int64) if steps is None else steps
    for axis, start, end, step in zip(axes, starts, ends, steps, strict=True):
        if step < 1:
            raise PolicyError(f"operator Slice: expected steps from 1 on, got {step}")
        picked[axis] = slice(int(start), int(end), int(step))
    return x[tuple(picked)]


def _squeeze(x: Tensor, axes: Tensor | None = None) -> Tensor:
    return np.squeeze(x, None if axes is None else tuple(int(axis) for axis in axes))


def _unsqueeze(x: Tensor, axes: Tensor) -> Tensor:
    return np.expand_dims(x, tuple(int(axis) for axis in axes))


def _softplus(x: Tensor) -> Tensor:
    return np.logaddexp(0.0, x)


OPERATORS: dict[str, Callable[[Attributes], Operator]] = {
    **ELEMENTWISE,
    **REDUCING,
    "Add": plain(np.add),
    "Cast": _cast,
    "Concat": _concat,
    "Div": plain(np.divide),
    "Flatten": _flatten,
    "Gemm": _gemm,
    "Identity": plain(lambda x: x),
    "MatMul": plain(np.matmul),
    "Mul": plain(np.multiply),
    "Relu": plain(lambda x: np.maximum(x, 0.0)),
    "Reshape": _reshape,
    "Sigmoid": plain(sigmoid),
    "Slice": plain(_slice),
    "Softplus": plain(_softplus),
    "Squeeze": plain(_squeeze),
    "Sub": plain(np.subtract),
    "Tanh": plain(np.tanh),
    "Transpose": _transpose,
    "Unsqueeze": plain(_unsqueeze),
}
"""Name of an ONNX operator → what makes its function from the attributes of a node."""
