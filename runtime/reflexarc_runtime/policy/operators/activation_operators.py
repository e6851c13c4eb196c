"""ONNX operators that stand between a network's layers: the usual activations.

Defaults are those of the ONNX specification. With σ the logistic function and Φ the cumulative
distribution of the normal one:

    Elu   x, below 0: α (eˣ − 1)          Selu  γ · Elu            Celu  x, below 0: α (eˣᐟᵅ − 1)
    Gelu  x Φ(x), or with tanh            Mish  x tanh(ln(1 + eˣ)) Swish x σ(α x)
    HardSigmoid  α x + β, within 0 and 1  HardSwish  x · HardSigmoid of 1/6 and 1/2
"""

import math

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.error_function import error_function
from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor, plain


def sigmoid(x: Tensor) -> Tensor:
    """1 / (1 + e⁻ˣ), without overflow on either side."""
    tail = np.exp(-np.abs(x))
    return np.where(x >= 0.0, 1.0, tail) / (1.0 + tail)


def _elu(node: OnnxNode) -> Operator:
    alpha = node.get("alpha", 1.0)
    return lambda x: np.where(x < 0.0, alpha * np.expm1(np.minimum(x, 0.0)), x)


def _selu(node: OnnxNode) -> Operator:
    alpha, gamma = node.get("alpha", 1.6732632423543772), node.get("gamma", 1.0507009873554805)
    return lambda x: gamma * np.where(x < 0.0, alpha * np.expm1(np.minimum(x, 0.0)), x)


def _celu(node: OnnxNode) -> Operator:
    alpha = node.get("alpha", 1.0)
    return lambda x: np.maximum(x, 0.0) + np.minimum(alpha * np.expm1(x / alpha), 0.0)


def _leaky_relu(node: OnnxNode) -> Operator:
    alpha = node.get("alpha", 0.01)
    return lambda x: np.where(x < 0.0, alpha * x, x)


def _thresholded_relu(node: OnnxNode) -> Operator:
    alpha = node.get("alpha", 1.0)
    return lambda x: np.where(x > alpha, x, 0.0)


def _p_relu(x: Tensor, slope: Tensor) -> Tensor:
    return np.where(x < 0.0, slope * x, x)


def _softplus(x: Tensor) -> Tensor:
    return np.logaddexp(0.0, x)


def _hard_sigmoid(node: OnnxNode) -> Operator:
    alpha, beta = node.get("alpha", 0.2), node.get("beta", 0.5)
    return lambda x: np.clip(alpha * x + beta, 0.0, 1.0)


def _gelu(node: OnnxNode) -> Operator:
    approximation = node.word("approximate", "none")
    if approximation == "none":
        return lambda x: 0.5 * x * (1.0 + error_function(x / math.sqrt(2.0)))
    if approximation != "tanh":
        raise PolicyError(f"operator Gelu: approximate={approximation}; none or tanh")
    factor = math.sqrt(2.0 / math.pi)
    return lambda x: 0.5 * x * (1.0 + np.tanh(factor * (x + 0.044715 * x * x * x)))


def _swish(node: OnnxNode) -> Operator:
    alpha = node.get("alpha", 1.0)
    return lambda x: x * sigmoid(alpha * x)


def _soft_max(x: Tensor, axis: int) -> Tensor:
    powers = np.exp(x - x.max(axis=axis, keepdims=True))
    shares: Tensor = powers / powers.sum(axis=axis, keepdims=True)
    return shares


def _log_soft_max(x: Tensor, axis: int) -> Tensor:
    below = x - x.max(axis=axis, keepdims=True)
    logs: Tensor = below - np.log(np.exp(below).sum(axis=axis, keepdims=True))
    return logs


def _shares(operator: Operator) -> Maker:
    """Over one axis; before version 13 over all axes from one on, by default the second."""

    def make(node: OnnxNode) -> Operator:
        if node.opset >= 13:
            axis = node.get("axis", -1)
            return lambda x: operator(x, axis)
        first = node.get("axis", 1)

        def of_rows(x: Tensor) -> Tensor:
            rows = x.reshape(math.prod(x.shape[:first]), -1)
            shares: Tensor = operator(rows, -1).reshape(x.shape)
            return shares

        return of_rows

    return make


ACTIVATIONS: dict[str, Maker] = {
    "Celu": _celu,
    "Elu": _elu,
    "Gelu": _gelu,
    "HardSigmoid": _hard_sigmoid,
    "HardSwish": plain(lambda x: x * np.clip(x / 6.0 + 0.5, 0.0, 1.0)),
    "LeakyRelu": _leaky_relu,
    "LogSoftmax": _shares(_log_soft_max),
    "Mish": plain(lambda x: x * np.tanh(_softplus(x))),
    "PRelu": plain(_p_relu),
    "Relu": plain(lambda x: np.maximum(x, 0)),
    "Selu": _selu,
    "Sigmoid": plain(sigmoid),
    "Softmax": _shares(_soft_max),
    "Softplus": plain(_softplus),
    "Softsign": plain(lambda x: x / (1.0 + np.abs(x))),
    "Swish": _swish,
    "Tanh": plain(np.tanh),
    "ThresholdedRelu": _thresholded_relu,
}
"""Name of an ONNX operator → what makes its function from a node."""
