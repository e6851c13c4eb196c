"""ONNX operators that go along axes: sums, extremes, their places, and the largest few."""

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor


def _reduce(operator: Operator) -> Maker:
    """Over all axes, unless some are given: as an attribute, or from a later version on as input.

    An input without any axis in it means all of them, or with `noop_with_empty_axes` none.
    """

    def make(node: OnnxNode) -> Operator:
        keep = bool(node.get("keepdims", 1))
        is_idle = bool(node.get("noop_with_empty_axes", 0))
        always = node.get("axes", ())

        def reduce(x: Tensor, axes: Tensor | None = None) -> Tensor:
            given = always if axes is None else axes
            is_over_all = not len(given) and not is_idle
            along = None if is_over_all else tuple(int(axis) for axis in given)
            # NumPy adds small whole numbers up in large ones; ONNX keeps the type.
            return np.asarray(operator(x, axis=along, keepdims=keep)).astype(x.dtype, copy=False)

        return reduce

    return make


def _l1(x: Tensor, **along: object) -> Tensor:
    return np.sum(np.abs(x), **along)  # type: ignore[call-overload, no-any-return]  # passed on


def _square_sum(x: Tensor, **along: object) -> Tensor:
    return np.sum(x * x, **along)  # type: ignore[call-overload, no-any-return]  # passed on


def _l2(x: Tensor, **along: object) -> Tensor:
    return np.sqrt(_square_sum(x, **along))


def _log_sum(x: Tensor, **along: object) -> Tensor:
    return np.log(np.sum(x, **along))  # type: ignore[call-overload, no-any-return]  # passed on


def _log_sum_exp(x: Tensor, axis: tuple[int, ...] | None, keepdims: bool) -> Tensor:
    highest = np.max(x, axis=axis, keepdims=True)
    logs: Tensor = np.log(np.sum(np.exp(x - highest), axis=axis, keepdims=True)) + highest
    return logs if keepdims else np.squeeze(logs, axis)


def _place(operator: Operator) -> Maker:
    """Index of an extreme value, after rounding to float32 as at the output of the graph."""

    def make(node: OnnxNode) -> Operator:
        axis, keep = node.get("axis", 0), bool(node.get("keepdims", 1))
        node.require("select_last_index", 0, "a tie must take the first action")
        return lambda x: operator(x.astype(np.float32), axis=axis, keepdims=keep)

    return make


def _top(node: OnnxNode) -> Operator:
    """The largest or smallest few, and their places; of equal ones, after rounding, the first."""
    axis, is_largest = node.get("axis", -1), bool(node.get("largest", 1))
    node.passes_over("sorted")  # sorted is one of the orders that are allowed without it

    def top(x: Tensor, count: Tensor) -> tuple[Tensor, Tensor]:
        k, rounded = int(count.reshape(-1)[0]), x.astype(np.float32)
        if not 0 <= k <= x.shape[axis]:
            raise PolicyError(f"operator TopK: expected k up to {x.shape[axis]}, got {k}")
        order = np.argsort(-rounded if is_largest else rounded, axis, kind="stable")
        places = np.take(order, np.arange(k), axis)
        return np.take_along_axis(x, places, axis), places

    return top


def _running_sum(node: OnnxNode) -> Operator:
    is_exclusive, is_reverse = bool(node.get("exclusive", 0)), bool(node.get("reverse", 0))

    def running_sum(x: Tensor, along: Tensor) -> Tensor:
        axis = int(along.reshape(-1)[0])
        ordered = np.flip(x, axis) if is_reverse else x
        sums: Tensor = np.cumsum(ordered, axis, dtype=x.dtype)
        if is_exclusive:
            sums = sums - ordered
        return np.flip(sums, axis) if is_reverse else sums

    return running_sum


REDUCING: dict[str, Maker] = {
    "ArgMax": _place(np.argmax),
    "ArgMin": _place(np.argmin),
    "CumSum": _running_sum,
    "ReduceL1": _reduce(_l1),
    "ReduceL2": _reduce(_l2),
    "ReduceLogSum": _reduce(_log_sum),
    "ReduceLogSumExp": _reduce(_log_sum_exp),
    "ReduceMax": _reduce(np.max),
    "ReduceMean": _reduce(np.mean),
    "ReduceMin": _reduce(np.min),
    "ReduceProd": _reduce(np.prod),
    "ReduceSum": _reduce(np.sum),
    "ReduceSumSquare": _reduce(_square_sum),
    "TopK": _top,
}
"""Name of an ONNX operator → what makes its function from a node."""
