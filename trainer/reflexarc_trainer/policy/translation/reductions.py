"""Rules for what goes along axes: sums, means, extremes, norms, and shares by softmax.

None may go along the batch: what one robot does would hang on what the others see.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812  # its usual name

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import (
    Call,
    Names,
    Rule,
    Translation,
    Value,
)
from reflexarc_trainer.policy.translation.parameters import weights


def _along(kind: str) -> Rule:
    """A sum, mean or extreme along given axes."""

    def rule(call: Call) -> str:
        given = call.given("dim", "keepdim", "axis", dim=None, keepdim=False, axis=None)
        dims = given["axis"] if given["dim"] is None else given["dim"]
        axes = _axes(call.args[0], dims)
        return _reduced(call.graph, kind, call.args[0].name, axes, keep=given["keepdim"])

    return rule


def _extreme(kind: str, place: str, of_two: str) -> Rule:
    """`x.max(dim)`: values and places; `torch.max(a, b)`: the larger ones."""

    def rule(call: Call) -> Names:
        graph, whole = call.graph, call.args[0]
        if len(call.args) > 1 and isinstance(call.args[1], Value):
            return graph.node(of_two, [whole.name, call.args[1].name])
        given = call.given("dim", "keepdim", dim=None, keepdim=False)
        axes = _axes(whole, given["dim"])
        keep = int(given["keepdim"])
        values = _reduced(graph, kind, whole.name, axes, keep=bool(keep))
        return values, graph.node(place, [whole.name], axis=axes[0], keepdims=keep)

    return rule


def _soft_max(call: Call) -> str:
    axis = _one_axis(call)
    return call.graph.node("Softmax", [call.args[0].name], axis=axis)


def _log_soft_max(call: Call) -> str:
    """LogSoftmax: z − log Σ e^z, with z = x − max x."""
    graph, axes = call.graph, [_one_axis(call)]
    peak = _reduced(graph, "ReduceMax", call.args[0].name, axes)
    z = graph.node("Sub", [call.args[0].name, peak])
    total = _reduced(graph, "ReduceSum", graph.node("Exp", [z]), axes)
    return graph.node("Sub", [z, graph.node("Log", [total])])


def _layer_norm(call: Call) -> str:
    names = ("normalized_shape", "weight", "bias", "eps")
    given = call.options(*names, weight=None, bias=None, eps=1e-5)
    shape, graph, x = given["normalized_shape"], call.graph, call.args[0]
    rank = len(x.shape)
    axes = list(range(rank - (len(shape) if isinstance(shape, tuple | list) else 1), rank))
    _axes(x, axes)
    away = graph.node("Sub", [x.name, _reduced(graph, "ReduceMean", x.name, axes)])
    scaled = graph.node("Div", [away, _root_mean_square(graph, away, axes, given["eps"])])
    return _scaled_and_shifted(graph, scaled, given["weight"], given["bias"])


def _rms_norm(call: Call) -> str:
    names = ("normalized_shape", "weight", "eps")
    given = call.options(*names, weight=None, eps=None)
    graph, x = call.graph, call.args[0]
    axes = list(range(len(x.shape) - len(given["normalized_shape"]), len(x.shape)))
    _axes(x, axes)
    eps = float(np.finfo(np.float32).eps) if given["eps"] is None else given["eps"]
    scaled = graph.node("Div", [x.name, _root_mean_square(graph, x.name, axes, eps)])
    return _scaled_and_shifted(graph, scaled, given["weight"], None)


def _batch_norm(call: Call) -> str:
    """With what it learned of its inputs: (x − mean) / √(variance + ε), scaled and shifted."""
    graph, module, x = call.graph, call.module, call.args[0]
    if module.running_mean is None:
        raise PolicyError(
            "export: BatchNorm without running statistics is not supported: what one robot does "
            "would hang on the others of its batch"
        )
    away = graph.node("Sub", [x.name, _channels(graph, x, module.running_mean)])
    spread = graph.node("Add", [_channels(graph, x, module.running_var), graph.number(module.eps)])
    scaled = graph.node("Div", [away, graph.node("Sqrt", [spread])])
    if module.weight is None:
        return scaled
    scaled = graph.node("Mul", [scaled, _channels(graph, x, module.weight)])
    return graph.node("Add", [scaled, _channels(graph, x, module.bias)])


def _root_mean_square(graph: Translation, x: str, axes: list[int], eps: float) -> str:
    squares = _reduced(graph, "ReduceMean", graph.node("Mul", [x, x]), axes)
    return graph.node("Sqrt", [graph.node("Add", [squares, graph.number(eps)])])


def _scaled_and_shifted(graph: Translation, x: str, gain: Any, shift: Any) -> str:
    for kind, part in (("Mul", gain), ("Add", shift)):
        if isinstance(part, Value):
            x = graph.node(kind, [x, part.name])
        elif part is not None:
            x = graph.node(kind, [x, graph.constant("scale", weights(part))])
    return x


def _channels(graph: Translation, x: Value, parts: torch.Tensor) -> str:
    """A value for each place along axis 1."""
    rows = weights(parts).reshape(-1, *[1] * (len(x.shape) - 2))
    return graph.constant("channels", rows)


def _reduced(graph: Translation, kind: str, x: str, axes: list[int], *, keep: bool = True) -> str:
    if kind == "ReduceSum":  # whose axes are an input
        return graph.node(kind, [x, graph.integers("axes", *axes)], keepdims=int(keep))
    return graph.node(kind, [x], axes=axes, keepdims=int(keep))


def _one_axis(call: Call) -> int:
    """The axis of a softmax."""
    if call.module is not None:
        dim = call.module.dim
    else:
        dim = call.given("dim", "_stacklevel", "dtype", dtype=None, _stacklevel=3)["dim"]
    if dim is None:
        raise PolicyError("export: Softmax without dim is not supported; say dim=-1")
    return _axes(call.args[0], dim)[0]


def _axes(x: Value, dims: Any) -> list[int]:
    """Axes counted from the front.

    Raises:
        PolicyError: the batch is among them.
    """
    given: Iterable[int] = range(len(x.shape)) if dims is None else _several(dims)
    axes = sorted(int(dim) % len(x.shape) for dim in given)
    if any(x.shape[axis] is None for axis in axes):
        raise PolicyError(
            "export: a sum, mean, extreme or norm over the batch is not supported: what one robot "
            "does would hang on the others; say dim=…"
        )
    return axes


def _several(dims: Any) -> Iterable[int]:
    return dims if isinstance(dims, tuple | list) else (dims,)


REDUCTION_RULES: dict[Any, Rule] = {
    **dict.fromkeys((torch.mean, "mean"), _along("ReduceMean")),
    **dict.fromkeys((torch.sum, "sum"), _along("ReduceSum")),
    **dict.fromkeys((torch.amax, "amax"), _along("ReduceMax")),
    **dict.fromkeys((torch.amin, "amin"), _along("ReduceMin")),
    **dict.fromkeys((torch.max, "max"), _extreme("ReduceMax", "ArgMax", "Max")),
    **dict.fromkeys((torch.min, "min"), _extreme("ReduceMin", "ArgMin", "Min")),
    **dict.fromkeys((nn.Softmax, torch.softmax, F.softmax, "softmax"), _soft_max),
    **dict.fromkeys(
        (nn.LogSoftmax, torch.log_softmax, F.log_softmax, "log_softmax"), _log_soft_max
    ),
    **dict.fromkeys((nn.LayerNorm, F.layer_norm), _layer_norm),
    **dict.fromkeys((nn.RMSNorm, F.rms_norm), _rms_norm),
    **dict.fromkeys((nn.BatchNorm1d, nn.BatchNorm2d), _batch_norm),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
