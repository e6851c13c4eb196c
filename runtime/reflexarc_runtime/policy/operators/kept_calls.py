"""Operators that write into arrays which are there already.

For each node: its arrays, and the calls, without arguments, after which they hold what its operator
would return. Those of common layers are NumPy's own functions, the same ones that the operator
calls, so that the bits are the same; what any other operator returns is copied. An operator that
only looks at its input otherwise, as a reshape does, needs no call: what it gave once is a view.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from reflexarc_runtime.policy.operators.graph_node import OnnxNode, Operator, Tensor

Call: TypeAlias = Callable[[], object]
Kept: TypeAlias = Callable[[OnnxNode, Sequence[Any], Tensor], list[Call] | None]
"""From a node, its inputs and its output to calls; None where it is a case for copying."""


def kept_calls(
    operator: Operator, node: OnnxNode, given: Sequence[Any]
) -> tuple[tuple[Tensor, ...], list[Call]]:
    """The arrays of a node's outputs, and the calls that compute them.

    Args:
        operator: its function.
        node: what it is.
        given: its inputs: the arrays themselves, whose contents change, and their shapes do not.
    """
    result = operator(*given)
    made = result if isinstance(result, tuple) else (result,)
    if all(_is_view(each, given) for each in made):
        return made, []
    kept = tuple(np.array(each) for each in made)
    return kept, _calls(operator, node, given, kept)


def _is_view(made: Tensor, given: Sequence[Any]) -> bool:
    """Whether it is an input seen otherwise, which it stays as long as the shapes are the same."""
    return isinstance(made, np.ndarray) and any(
        isinstance(array, np.ndarray) and np.may_share_memory(made, array) for array in given
    )


def _calls(
    operator: Operator, node: OnnxNode, given: Sequence[Any], kept: tuple[Tensor, ...]
) -> list[Call]:
    calls = None
    if len(kept) == 1:
        if isinstance(operator, np.ufunc):
            return [partial(operator, *given, kept[0])]
        calls = KEPT[node.kind](node, given, kept[0]) if node.kind in KEPT else None
    return [partial(_copied, operator, tuple(given), kept)] if calls is None else calls


def _copied(operator: Operator, given: Sequence[Any], kept: Sequence[Tensor]) -> None:
    result = operator(*given)
    for array, made in zip(kept, result if isinstance(result, tuple) else (result,), strict=True):
        np.copyto(array, made)


def _cast(node: OnnxNode, given: Sequence[Any], kept: Tensor) -> list[Call] | None:
    """Between types where nothing is rounded on the way to a third one."""
    if kept.dtype != np.float64 or given[0].dtype.kind not in "biu":
        return None
    return [partial(np.copyto, kept, given[0])]


def _divide(node: OnnxNode, given: Sequence[Any], kept: Tensor) -> list[Call] | None:
    if kept.dtype.kind != "f":
        return None
    return [partial(np.divide, *given, kept)]


def _relu(node: OnnxNode, given: Sequence[Any], kept: Tensor) -> list[Call]:
    return [partial(np.maximum, given[0], 0, out=kept)]  # by place it is deprecated


def _gemm(node: OnnxNode, given: Sequence[Any], kept: Tensor) -> list[Call] | None:
    if (node.get("alpha", 1.0), node.get("beta", 1.0)) != (1.0, 1.0):
        return None
    a = given[0].T if node.get("transA", 0) else given[0]
    b = given[1].T if node.get("transB", 0) else given[1]
    added = given[2] if len(given) > 2 else 0.0
    product = np.matmul(a, b)
    return [partial(np.matmul, a, b, product), partial(np.add, product, added, kept)]


def _place(find: str) -> Kept:
    """Index of an extreme value, after rounding to float32."""

    def make(node: OnnxNode, given: Sequence[Any], kept: Tensor) -> list[Call]:
        rounded = np.empty(given[0].shape, np.float32)
        keep = bool(node.get("keepdims", 1))
        found = getattr(rounded, find)
        return [
            partial(np.copyto, rounded, given[0], "same_kind"),
            partial(found, node.get("axis", 0), kept, keepdims=keep),
        ]

    return make


KEPT: dict[str, Kept] = {
    "ArgMax": _place("argmax"),
    "ArgMin": _place("argmin"),
    "Cast": _cast,
    "Div": _divide,
    "Gemm": _gemm,
    "Relu": _relu,
}
"""Name of an ONNX operator → what makes its calls."""
