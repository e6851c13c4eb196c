"""Rules for arithmetic, comparisons and choices, element by element."""

import operator
from typing import Any

import onnx
import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812  # its usual name

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.q_network import intensity
from reflexarc_trainer.policy.translation.graph_builder import Call, Rule


def _plain(kind: str) -> Rule:
    """An operator whose inputs are values or numbers, and that has no attributes."""

    def rule(call: Call) -> str:
        if any(key not in ("inplace", "other") for key in call.kwargs):
            raise PolicyError(f"export: {kind} with {', '.join(call.kwargs)} is not supported")
        given = [*call.args, *(v for k, v in call.kwargs.items() if k == "other")]
        return call.graph.node(kind, [call.graph.named(a) for a in given])

    return rule


def _turned_round(call: Call) -> str:
    """Reads `rsub(a, b)`: b − a."""
    given = call.given("other", "alpha", alpha=1)
    if given["alpha"] != 1:
        raise PolicyError("export: rsub with alpha is not supported")
    return call.graph.node("Sub", [call.graph.named(given["other"]), call.args[0].name])


def _power(call: Call) -> str:
    """Whole powers by multiplications, which every backend has for numbers below 0 too."""
    graph, exponent = call.graph, call.given("exponent")["exponent"]
    name = call.args[0].name
    if isinstance(exponent, int | float) and exponent in (2, 3, 4):
        squared = graph.node("Mul", [name, name])
        if exponent == 2:
            return squared
        return graph.node("Mul", [squared, name if exponent == 3 else squared])
    return graph.node("Pow", [name, graph.named(exponent)])


def _square(call: Call) -> str:
    return call.graph.node("Mul", [call.args[0].name] * 2)


def _inverse(kind: str | None) -> Rule:
    """Reads 1 / x, or 1 / √x."""

    def rule(call: Call) -> str:
        graph, name = call.graph, call.args[0].name
        below = graph.node(kind, [name]) if kind else name
        return graph.node("Div", [graph.number(1.0), below])

    return rule


def _different(call: Call) -> str:
    return call.graph.node("Not", [call.graph.node("Equal", [*map(call.graph.named, call.args)])])


def _chosen(call: Call) -> str:
    condition, left, right = call.args
    return call.graph.node(
        "Where", [condition.name, call.graph.named(left), call.graph.named(right)]
    )


def _as_float(call: Call) -> str:
    """What was a truth or a whole number becomes a float."""
    return call.graph.node("Cast", [call.args[0].name], to=onnx.TensorProto.FLOAT)


def _weighted(call: Call) -> str:
    """`F.linear`: x Wᵀ + b."""
    graph, given = call.graph, call.given("weight", "bias", bias=None)
    turned = graph.node("Transpose", [given["weight"].name], perm=[1, 0])
    product = graph.node("MatMul", [call.args[0].name, turned])
    if given["bias"] is None:
        return product
    return graph.node("Add", [product, given["bias"].name])


def _same(call: Call) -> str:
    return str(call.args[0].name)


def _dropped(call: Call) -> str:
    """`F.dropout`, which does nothing in a network that is not being trained."""
    if call.given("p", "training", "inplace", p=0.5, training=True)["training"]:
        raise PolicyError("export: F.dropout draws at random; say training=self.training")
    return _same(call)


def _named(rule: Rule, *keys: Any) -> dict[Any, Rule]:
    return dict.fromkeys(keys, rule)


ARITHMETIC_RULES: dict[Any, Rule] = {
    # These add no node: the graph before the module divides by 255, and the others do nothing
    # in a network that is not being trained.
    **_named(_same, intensity, nn.Identity, nn.Dropout, nn.Dropout1d, nn.Dropout2d),
    **_named(_same, nn.AlphaDropout, "contiguous", "clone", torch.clone, "detach"),
    **_named(_dropped, F.dropout),
    **_named(_as_float, "double"),
    **_named(_plain("Add"), operator.add, torch.add, "add"),
    **_named(_plain("Sub"), operator.sub, torch.sub, torch.subtract, "sub"),
    **_named(_turned_round, torch.rsub),
    **_named(_plain("Mul"), operator.mul, torch.mul, torch.multiply, "mul"),
    **_named(_plain("Div"), operator.truediv, torch.div, torch.divide, torch.true_divide, "div"),
    **_named(_plain("MatMul"), operator.matmul, torch.matmul, "matmul", torch.bmm, torch.mm),
    **_named(_weighted, F.linear),
    **_named(_plain("Neg"), operator.neg, torch.neg, "neg"),
    **_named(_plain("Abs"), operator.abs, abs, torch.abs, "abs"),
    **_named(_plain("Exp"), torch.exp, "exp"),
    **_named(_plain("Log"), torch.log, "log"),
    **_named(_plain("Sqrt"), torch.sqrt, "sqrt"),
    **_named(_plain("Sin"), torch.sin, "sin"),
    **_named(_plain("Cos"), torch.cos, "cos"),
    **_named(_plain("Atan"), torch.atan, torch.arctan, "atan"),
    **_named(_plain("Sign"), torch.sign, "sign"),
    **_named(_plain("Max"), torch.maximum, "maximum"),
    **_named(_plain("Min"), torch.minimum, "minimum"),
    **_named(_inverse(None), torch.reciprocal, "reciprocal"),
    **_named(_inverse("Sqrt"), torch.rsqrt, "rsqrt"),
    **_named(_power, operator.pow, torch.pow, "pow"),
    **_named(_square, torch.square, "square"),
    **_named(_plain("Greater"), operator.gt, torch.gt, "gt"),
    **_named(_plain("GreaterOrEqual"), operator.ge, torch.ge, "ge"),
    **_named(_plain("Less"), operator.lt, torch.lt, "lt"),
    **_named(_plain("LessOrEqual"), operator.le, torch.le, "le"),
    **_named(_plain("Equal"), operator.eq, torch.eq, "eq"),
    **_named(_different, operator.ne, torch.ne, "ne"),
    **_named(_chosen, torch.where),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
