"""ONNX operators that shift and scale to a mean of 0 and a deviation of 1, as networks are trained.

    y = (x − mean) / √(variance + ε) · scale + bias

The mean and variance are given (batch), or those of each row (layer), each channel of each row
(instance), or each group of channels of each row (group). Arrays are (n, channels, *space).
"""

import numpy as np

from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor

_EPSILON = 1e-5


def _batch(node: OnnxNode) -> Operator:
    epsilon = node.get("epsilon", _EPSILON)
    node.passes_over("momentum")  # for training
    node.require("training_mode", 0, "a policy must be exported for inference: model.eval()")
    node.require("spatial", 1, "a channel must have one mean")

    def normalise(x: Tensor, scale: Tensor, bias: Tensor, mean: Tensor, variance: Tensor) -> Tensor:
        scale, bias, mean, variance = (_of_channels(a, x) for a in (scale, bias, mean, variance))
        result: Tensor = (x - mean) / np.sqrt(variance + epsilon) * scale + bias
        return result

    return normalise


def _layer(node: OnnxNode) -> Operator:
    axis, epsilon = node.get("axis", -1), node.get("epsilon", _EPSILON)
    node.passes_over("stash_type")

    def normalise(x: Tensor, scale: Tensor, bias: Tensor | float = 0.0) -> Tensor:
        result: Tensor = _normal(x, _from(x, axis), epsilon) * scale + bias
        return result

    return normalise


def _root_mean_square(node: OnnxNode) -> Operator:
    axis, epsilon = node.get("axis", -1), node.get("epsilon", _EPSILON)
    node.passes_over("stash_type")

    def normalise(x: Tensor, scale: Tensor) -> Tensor:
        square = np.mean(x * x, axis=_from(x, axis), keepdims=True)
        result: Tensor = x / np.sqrt(square + epsilon) * scale
        return result

    return normalise


def _instance(node: OnnxNode) -> Operator:
    epsilon = node.get("epsilon", _EPSILON)

    def normalise(x: Tensor, scale: Tensor, bias: Tensor) -> Tensor:
        space = tuple(range(2, x.ndim))
        return _normal(x, space, epsilon) * _of_channels(scale, x) + _of_channels(bias, x)

    return normalise


def _group(node: OnnxNode) -> Operator:
    """Scale and bias are those of a group before version 21, those of a channel from it on."""
    groups, epsilon = node["num_groups"], node.get("epsilon", _EPSILON)
    node.passes_over("stash_type")

    def normalise(x: Tensor, scale: Tensor, bias: Tensor) -> Tensor:
        each = x.reshape(x.shape[0], groups, -1)
        normal = _normal(each, (2,), epsilon).reshape(x.shape)
        if node.opset < 21:
            channels = x.shape[1] // groups
            scale, bias = np.repeat(scale, channels), np.repeat(bias, channels)
        return normal * _of_channels(scale, x) + _of_channels(bias, x)

    return normalise


def _length(node: OnnxNode) -> Operator:
    axis, power = node.get("axis", -1), node.get("p", 2)

    def normalise(x: Tensor) -> Tensor:
        length = np.linalg.norm(x, power, axis, keepdims=True)
        return np.where(length == 0.0, 0.0, x / length)

    return normalise


def _normal(x: Tensor, axes: tuple[int, ...], epsilon: float) -> Tensor:
    around = x - np.mean(x, axis=axes, keepdims=True)
    result: Tensor = around / np.sqrt(np.mean(around * around, axis=axes, keepdims=True) + epsilon)
    return result


def _from(x: Tensor, axis: int) -> tuple[int, ...]:
    return tuple(range(axis % x.ndim, x.ndim))


def _of_channels(numbers: Tensor, x: Tensor) -> Tensor:
    return numbers.reshape(-1, *[1] * (x.ndim - 2))


NORMALISING: dict[str, Maker] = {
    "BatchNormalization": _batch,
    "GroupNormalization": _group,
    "InstanceNormalization": _instance,
    "LayerNormalization": _layer,
    "LpNormalization": _length,
    "RMSNormalization": _root_mean_square,
}
"""Name of an ONNX operator → what makes its function from a node."""
