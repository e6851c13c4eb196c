"""ONNX operators that compute each element by itself: functions, comparisons and choices.

Numbers are float64 here, so a comparison may say otherwise than onnxruntime's of float32 where both
sides differ by rounding. What hangs on it may then differ by more: a rule that jumps there has to
be given room, or to decide on whole numbers.
"""

from functools import reduce

import numpy as np

from reflexarc_runtime.policy.operators.error_function import error_function
from reflexarc_runtime.policy.operators.graph_node import (
    Maker,
    OnnxNode,
    Operator,
    Tensor,
    caster,
    plain,
)


def _cast(node: OnnxNode) -> Operator:
    node.passes_over("saturate", "round_mode")  # of floats of 8 bits alone
    return caster(node["to"])


def _clip(node: OnnxNode) -> Operator:
    """The limits may be absent; where the lower is above the higher, the higher counts.

    They are inputs from version 11 on.
    """
    lowest, highest = node.get("min"), node.get("max")

    def clip(x: Tensor, low: Tensor | None = lowest, high: Tensor | None = highest) -> Tensor:
        raised = x if low is None else np.maximum(x, low)
        return raised if high is None else np.minimum(raised, high)

    return clip


def _divide(x: Tensor, y: Tensor) -> Tensor:
    """Whole numbers are cut off towards 0."""
    if x.dtype.kind == "f" or y.dtype.kind == "f":
        return np.divide(x, y)
    quotient: Tensor = np.floor_divide(x, y)
    result: Tensor = quotient + ((quotient < 0) & (quotient * y != x)).astype(quotient.dtype)
    return result


def _power(x: Tensor, y: Tensor) -> Tensor:
    """Of the base's type."""
    result: Tensor = np.power(x.astype(np.float64), y) if y.dtype.kind == "f" else np.power(x, y)
    return result.astype(x.dtype)


def _mod(node: OnnxNode) -> Operator:
    """Of whole numbers, with the sign of the divisor."""
    node.require("fmod", 0, "only whole numbers, with the divisor's sign")
    return np.mod


def _mean(*inputs: Tensor) -> Tensor:
    return np.divide(reduce(np.add, inputs), len(inputs))


def _is_infinite(node: OnnxNode) -> Operator:
    above, below = node.get("detect_positive", 1), node.get("detect_negative", 1)
    return lambda x: np.isinf(x) & np.where(x > 0.0, bool(above), bool(below))


def _dropout(node: OnnxNode) -> Operator:
    """Drops nothing: it is for training."""
    node.passes_over("ratio", "seed")
    return lambda x, *_: x


def _of_any_number(operator: Operator) -> Maker:
    """The maker of an operator of one input or more."""
    return plain(lambda *inputs: reduce(operator, inputs))


ELEMENTWISE: dict[str, Maker] = {
    "Abs": plain(np.abs),
    "Acos": plain(np.arccos),
    "Acosh": plain(np.arccosh),
    "Add": plain(np.add),
    "And": plain(np.logical_and),
    "Asin": plain(np.arcsin),
    "Asinh": plain(np.arcsinh),
    "Atan": plain(np.arctan),
    "Atanh": plain(np.arctanh),
    "Cast": _cast,
    "Ceil": plain(np.ceil),
    "Clip": _clip,
    "Cos": plain(np.cos),
    "Cosh": plain(np.cosh),
    "Div": plain(_divide),
    "Dropout": _dropout,
    "Equal": plain(np.equal),
    "Erf": plain(error_function),
    "Exp": plain(np.exp),
    "Floor": plain(np.floor),
    "Greater": plain(np.greater),
    "GreaterOrEqual": plain(np.greater_equal),
    "Identity": plain(lambda x: x),
    "IsInf": _is_infinite,
    "IsNaN": plain(np.isnan),
    "Less": plain(np.less),
    "LessOrEqual": plain(np.less_equal),
    "Log": plain(np.log),
    "Max": _of_any_number(np.maximum),
    "Mean": plain(_mean),
    "Min": _of_any_number(np.minimum),
    "Mod": _mod,
    "Mul": plain(np.multiply),
    "Neg": plain(np.negative),
    "Not": plain(np.logical_not),
    "Or": plain(np.logical_or),
    "Pow": plain(_power),
    "Reciprocal": plain(lambda x: 1.0 / x),
    "Round": plain(np.rint),
    "Sign": plain(np.sign),
    "Sin": plain(np.sin),
    "Sinh": plain(np.sinh),
    "Sqrt": plain(np.sqrt),
    "Sub": plain(np.subtract),
    "Sum": _of_any_number(np.add),
    "Tan": plain(np.tan),
    "Where": plain(np.where),
    "Xor": plain(np.logical_xor),
}
"""Name of an ONNX operator → what makes its function from a node."""
