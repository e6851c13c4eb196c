"""ONNX operators that compute each element by itself: functions, comparisons and choices.

Numbers are float64 here, so a comparison may say otherwise than onnxruntime's of float32 where both
sides differ by rounding. What hangs on it may then differ by more: a rule that jumps there has to
be given room, or to decide on whole numbers.
"""

from functools import reduce

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operator import Attributes, Maker, Operator, Tensor, plain


def _clip(x: Tensor, low: Tensor | None = None, high: Tensor | None = None) -> Tensor:
    """The limits may be absent; where the lower is above the higher, the higher counts."""
    raised = x if low is None else np.maximum(x, low)
    return raised if high is None else np.minimum(raised, high)


def _elu(attributes: Attributes) -> Operator:
    alpha = attributes.get("alpha", 1.0)
    return lambda x: np.where(x < 0.0, alpha * np.expm1(np.minimum(x, 0.0)), x)


def _leaky_relu(attributes: Attributes) -> Operator:
    alpha = attributes.get("alpha", 0.01)
    return lambda x: np.where(x < 0.0, alpha * x, x)


def _mod(attributes: Attributes) -> Operator:
    """Of whole numbers, with the sign of the divisor."""
    if attributes.get("fmod", 0):
        raise PolicyError("operator Mod: fmod=1; only whole numbers, with the divisor's sign")
    return np.mod


def _of_any_number(operator: Operator) -> Maker:
    """The maker of an operator of one input or more."""
    return plain(lambda *inputs: reduce(operator, inputs))


ELEMENTWISE: dict[str, Maker] = {
    "Abs": plain(np.abs),
    "Acos": plain(np.arccos),
    "And": plain(np.logical_and),
    "Asin": plain(np.arcsin),
    "Atan": plain(np.arctan),
    "Clip": plain(_clip),
    "Cos": plain(np.cos),
    "Elu": _elu,
    "Equal": plain(np.equal),
    "Exp": plain(np.exp),
    "Floor": plain(np.floor),
    "Greater": plain(np.greater),
    "GreaterOrEqual": plain(np.greater_equal),
    "LeakyRelu": _leaky_relu,
    "Less": plain(np.less),
    "LessOrEqual": plain(np.less_equal),
    "Log": plain(np.log),
    "Max": _of_any_number(np.maximum),
    "Min": _of_any_number(np.minimum),
    "Mod": _mod,
    "Neg": plain(np.negative),
    "Not": plain(np.logical_not),
    "Or": plain(np.logical_or),
    "Pow": plain(np.power),
    "Sign": plain(np.sign),
    "Sin": plain(np.sin),
    "Sqrt": plain(np.sqrt),
    "Where": plain(np.where),
}
"""Name of an ONNX operator → what makes its function from the attributes of a node."""
