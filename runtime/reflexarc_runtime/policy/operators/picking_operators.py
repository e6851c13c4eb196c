"""ONNX operators that take elements by their places, and products of matrices."""

import numpy as np

from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor, plain


def _gather(node: OnnxNode) -> Operator:
    axis = node.get("axis", 0)
    return lambda x, places: np.take(x, places, axis=axis)


def _gather_elements(node: OnnxNode) -> Operator:
    axis = node.get("axis", 0)

    def gather(x: Tensor, places: Tensor) -> Tensor:
        # Along the other axes ONNX lets the places be fewer than the elements.
        others = [slice(size) for size in places.shape]
        others[axis] = slice(None)
        return np.take_along_axis(x[tuple(others)], places, axis)

    return gather


def _gather_nd(node: OnnxNode) -> Operator:
    """The last axis of the places holds the first coordinates of an element or a part."""
    node.require("batch_dims", 0, "places must be of the whole array")

    def gather(x: Tensor, places: Tensor) -> Tensor:
        picked: Tensor = x[tuple(np.moveaxis(places, -1, 0))]
        return picked

    return gather


def _one_hot(node: OnnxNode) -> Operator:
    axis = node.get("axis", -1)

    def one_hot(places: Tensor, depth: Tensor, values: Tensor) -> Tensor:
        count = int(depth.reshape(-1)[0])
        # Places from the end count too.
        counted = np.where(places < 0, places + count, places)
        found = np.moveaxis(counted[..., np.newaxis] == np.arange(count), -1, axis)
        result: Tensor = np.where(found, values[1], values[0])
        return result

    return one_hot


def _gemm(node: OnnxNode) -> Operator:
    alpha, beta = node.get("alpha", 1.0), node.get("beta", 1.0)
    transpose_a, transpose_b = node.get("transA", 0), node.get("transB", 0)

    def gemm(a: Tensor, b: Tensor, c: Tensor | float = 0.0) -> Tensor:
        product = (a.T if transpose_a else a) @ (b.T if transpose_b else b)
        return alpha * product + beta * c if (alpha, beta) != (1.0, 1.0) else product + c

    return gemm


def _einsum(node: OnnxNode) -> Operator:
    equation = node.word("equation", "")
    return lambda *inputs: np.einsum(equation, *inputs)


PICKING: dict[str, Maker] = {
    "Einsum": _einsum,
    "Gather": _gather,
    "GatherElements": _gather_elements,
    "GatherND": _gather_nd,
    "Gemm": _gemm,
    "MatMul": plain(np.matmul),
    "OneHot": _one_hot,
}
"""Name of an ONNX operator → what makes its function from a node."""
