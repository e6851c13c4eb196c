"""ONNX operators that go along an axis: sums, extremes, their places, and elements by place."""

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operator import Attributes, Maker, Operator, Tensor


def _reduce(operator: Operator) -> Maker:
    """Over all axes, unless some are given: as an attribute, or from a later version on as input.

    An input without any axis in it means all of them, or with `noop_with_empty_axes` none.
    """

    def make(attributes: Attributes) -> Operator:
        keep = bool(attributes.get("keepdims", 1))
        is_idle = bool(attributes.get("noop_with_empty_axes", 0))

        def reduce(x: Tensor, axes: Tensor | None = None) -> Tensor:
            given = attributes.get("axes", ()) if axes is None else axes
            if not len(given):
                return x if is_idle else operator(x, axis=None, keepdims=keep)
            return operator(x, axis=tuple(int(axis) for axis in given), keepdims=keep)

        return reduce

    return make


def _place(operator: Operator, kind: str) -> Maker:
    """Index of an extreme value, after rounding to float32 as at the output of the graph."""

    def make(attributes: Attributes) -> Operator:
        axis, keep = attributes.get("axis", 0), bool(attributes.get("keepdims", 1))
        if attributes.get("select_last_index", 0):
            raise PolicyError(
                f"operator {kind}: select_last_index=1; a tie must take the first action"
            )
        return lambda x: operator(x.astype(np.float32), axis=axis, keepdims=keep)

    return make


def _soft_max(attributes: Attributes) -> Operator:
    axis = attributes.get("axis", -1)

    def soft_max(x: Tensor) -> Tensor:
        powers = np.exp(x - x.max(axis=axis, keepdims=True))
        shares: Tensor = powers / powers.sum(axis=axis, keepdims=True)
        return shares

    return soft_max


def _gather(attributes: Attributes) -> Operator:
    axis = attributes.get("axis", 0)
    return lambda x, places: np.take(x, places, axis=axis)


def _gather_elements(attributes: Attributes) -> Operator:
    axis = attributes.get("axis", 0)

    def gather(x: Tensor, places: Tensor) -> Tensor:
        # Along the other axes ONNX lets the places be fewer than the elements.
        others = [slice(size) for size in places.shape]
        others[axis] = slice(None)
        return np.take_along_axis(x[tuple(others)], places, axis)

    return gather


REDUCING: dict[str, Maker] = {
    "ArgMax": _place(np.argmax, "ArgMax"),
    "ArgMin": _place(np.argmin, "ArgMin"),
    "Gather": _gather,
    "GatherElements": _gather_elements,
    "ReduceMax": _reduce(np.max),
    "ReduceMean": _reduce(np.mean),
    "ReduceMin": _reduce(np.min),
    "ReduceSum": _reduce(np.sum),
    "Softmax": _soft_max,
}
"""Name of an ONNX operator → what makes its function from the attributes of a node."""
