"""Rules for functions of one element: torch's activations, written in operators of every backend.

Most have an ONNX operator of their own only in versions that older runtimes do not read, so they
are written out by their formulas.
"""

import math
from typing import Any

import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812  # its usual name

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import Call, Rule, Translation, Value
from reflexarc_trainer.policy.translation.parameters import weights

_SELU_ALPHA, _SELU_SCALE = 1.6732632423543772, 1.0507009873554805
_TANH_GELU = 0.044715
"""Hendrycks and Gimpel, Gaussian Error Linear Units (2016): x Φ(x) by a tanh."""


def _sigmoid(graph: Translation, x: str) -> str:
    return graph.node("Sigmoid", [x])


def _leaky_relu(call: Call) -> str:
    slope = call.options("negative_slope", negative_slope=0.01)["negative_slope"]
    return _sloped(call, slope)


def _randomised_relu(call: Call) -> str:
    """Not being trained it takes the middle of its slopes."""
    return _sloped(call, (call.module.lower + call.module.upper) / 2)


def _sloped(call: Call, slope: float) -> str:
    graph = call.graph
    return graph.node("LeakyRelu", [call.args[0].name], alpha=graph.rounded(slope))


def _elu(call: Call) -> str:
    alpha = call.options("alpha", alpha=1.0)["alpha"]
    return call.graph.node("Elu", [call.args[0].name], alpha=call.graph.rounded(alpha))


def _celu(call: Call) -> str:
    """CELU: α ELU(x / α)."""
    graph, alpha = call.graph, call.options("alpha", alpha=1.0)["alpha"]
    inner = graph.node("Div", [call.args[0].name, graph.number(alpha)])
    return graph.node("Mul", [graph.number(alpha), graph.node("Elu", [inner], alpha=1.0)])


def _selu(call: Call) -> str:
    graph = call.graph
    elu = graph.node("Elu", [call.args[0].name], alpha=graph.rounded(_SELU_ALPHA))
    return graph.node("Mul", [graph.number(_SELU_SCALE), elu])


def _gelu(call: Call) -> str:
    """GELU: x Φ(x), Φ by the error function, or about it by a tanh."""
    graph, x = call.graph, call.args[0].name
    if call.options("approximate", approximate="none")["approximate"] == "tanh":
        cubed = graph.node("Mul", [graph.node("Mul", [x, x]), x])
        inner = graph.node("Add", [x, graph.node("Mul", [graph.number(_TANH_GELU), cubed])])
        inner = graph.node("Mul", [graph.number(math.sqrt(2 / math.pi)), inner])
        share = graph.node("Tanh", [inner])
    else:
        share = graph.node("Erf", [graph.node("Mul", [x, graph.number(math.sqrt(0.5))])])
    half = graph.node("Mul", [x, graph.number(0.5)])
    return graph.node("Mul", [half, graph.node("Add", [share, graph.number(1.0)])])


def _silu(call: Call) -> str:
    x = call.args[0].name
    return call.graph.node("Mul", [x, _sigmoid(call.graph, x)])


def _mish(call: Call) -> str:
    """Mish: x tanh(softplus(x))."""
    graph, x = call.graph, call.args[0].name
    return graph.node("Mul", [x, graph.node("Tanh", [graph.node("Softplus", [x])])])


def _softplus(call: Call) -> str:
    """Softplus: log(1 + e^(β x)) / β; the straight line that torch takes at its end is the same."""
    graph = call.graph
    given = call.options("beta", "threshold", beta=1.0, threshold=20.0)
    if given["threshold"] < 20.0 or not given["beta"]:
        raise PolicyError("export: Softplus with a threshold below 20 or beta=0 is not supported")
    if given["beta"] == 1:
        return graph.node("Softplus", [call.args[0].name])
    beta = graph.number(given["beta"])
    inner = graph.node("Softplus", [graph.node("Mul", [call.args[0].name, beta])])
    return graph.node("Div", [inner, beta])


def _log_sigmoid(call: Call) -> str:
    """The logarithm of σ(x): −softplus(−x)."""
    graph = call.graph
    return graph.node("Neg", [graph.node("Softplus", [graph.node("Neg", [call.args[0].name])])])


def _softsign(call: Call) -> str:
    graph, x = call.graph, call.args[0].name
    return graph.node("Div", [x, graph.node("Add", [graph.node("Abs", [x]), graph.number(1.0)])])


def _hard_tanh(call: Call) -> str:
    given = call.options("min_val", "max_val", min_val=-1.0, max_val=1.0)
    return _between(call.graph, call.args[0].name, given["min_val"], given["max_val"])


def _relu6(call: Call) -> str:
    return _between(call.graph, call.args[0].name, 0.0, 6.0)


def _hard_sigmoid(call: Call) -> str:
    return _shifted_sixth(call.graph, call.args[0].name)


def _hard_swish(call: Call) -> str:
    x = call.args[0].name
    return call.graph.node("Mul", [x, _shifted_sixth(call.graph, x)])


def _shifted_sixth(graph: Translation, x: str) -> str:
    clipped = _between(graph, graph.node("Add", [x, graph.number(3.0)]), 0.0, 6.0)
    return graph.node("Div", [clipped, graph.number(6.0)])


def _between(graph: Translation, x: str, low: float, high: float) -> str:
    return graph.node("Clip", [x, graph.number(low), graph.number(high)])


def _clamp(call: Call) -> str:
    given = call.given("min", "max", min=None, max=None)
    ends = ["" if end is None else call.graph.named(end) for end in (given["min"], given["max"])]
    return call.graph.node(
        "Clip", [call.args[0].name, *ends] if ends[1] else [call.args[0].name, *ends[:1]]
    )


def _p_relu(call: Call) -> str:
    """PReLU: max(0, x) + w min(0, x), a w for every channel or one for all."""
    graph, x = call.graph, call.args[0]
    if call.module is not None:
        rows = weights(call.module.weight)
        slope = graph.constant("slope", rows.reshape(-1, *[1] * max(0, len(x.shape) - 2)))
    else:
        slope = _slope_of(call)
    low = graph.node("Min", [x.name, graph.number(0.0)])
    return graph.node("Add", [graph.node("Relu", [x.name]), graph.node("Mul", [slope, low])])


def _slope_of(call: Call) -> str:
    slope: Value = call.given("weight")["weight"]
    rank = len(call.args[0].shape)
    if rank <= 2 or slope.shape == (1,):
        return slope.name
    return call.graph.node(
        "Reshape", [slope.name, call.graph.integers("shape", -1, *[1] * (rank - 2))]
    )


def _gated(call: Call) -> str:
    """GLU: the one half of an axis, times σ of the other."""
    graph, whole = call.graph, call.args[0]
    axis = call.options("dim", dim=-1)["dim"] % len(whole.shape)
    sizes = graph.integers("sizes", *[whole.shape[axis] // 2] * 2)
    left, right = graph.many("Split", [whole.name, sizes], 2, axis=axis)
    return graph.node("Mul", [left, _sigmoid(graph, right)])


def _plain(kind: str) -> Rule:
    def rule(call: Call) -> str:
        call.options()  # refuses what it does not know
        return call.graph.node(kind, [call.args[0].name])

    return rule


def _named(rule: Rule, *keys: Any) -> dict[Any, Rule]:
    return dict.fromkeys(keys, rule)


ACTIVATION_RULES: dict[Any, Rule] = {
    **_named(_plain("Sigmoid"), nn.Sigmoid, torch.sigmoid, F.sigmoid, "sigmoid"),
    **_named(_plain("Tanh"), nn.Tanh, torch.tanh, F.tanh, "tanh"),
    **_named(_plain("Relu"), nn.ReLU, torch.relu, F.relu, "relu"),
    **_named(_leaky_relu, nn.LeakyReLU, F.leaky_relu),
    **_named(_randomised_relu, nn.RReLU),
    **_named(_elu, nn.ELU, F.elu),
    **_named(_celu, nn.CELU, F.celu, torch.celu),
    **_named(_selu, nn.SELU, F.selu, torch.selu),
    **_named(_gelu, nn.GELU, F.gelu),
    **_named(_silu, nn.SiLU, F.silu),
    **_named(_mish, nn.Mish, F.mish),
    **_named(_softplus, nn.Softplus, F.softplus),
    **_named(_log_sigmoid, nn.LogSigmoid, F.logsigmoid),
    **_named(_softsign, nn.Softsign, F.softsign),
    **_named(_hard_tanh, nn.Hardtanh, F.hardtanh),
    **_named(_relu6, nn.ReLU6, F.relu6),
    **_named(_hard_sigmoid, nn.Hardsigmoid, F.hardsigmoid),
    **_named(_hard_swish, nn.Hardswish, F.hardswish),
    **_named(_p_relu, nn.PReLU, F.prelu, torch.prelu),
    **_named(_gated, nn.GLU, F.glu),
    **_named(_clamp, torch.clamp, "clamp", torch.clip, "clip"),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
