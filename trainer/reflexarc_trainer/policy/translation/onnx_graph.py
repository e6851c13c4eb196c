"""Translation of a torch module to ONNX nodes, by one small table of rules.

`torch.fx` traces the module; each call of the trace is a module's class, a function or a method's
name, and the table says how it is written in ONNX. Others are refused by name, for replay needs
graphs that the NumPy reference can compute.
"""

import operator
from typing import Any

import numpy as np
import torch
from torch import fx, nn

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.q_network import intensity
from reflexarc_trainer.policy.translation.graph_builder import (
    Call,
    Names,
    Rule,
    Shape,
    Translation,
    Value,
)
from reflexarc_trainer.policy.translation.parameters import weights
from reflexarc_trainer.policy.translation.recurrent_modules import RECURRENT_RULES
from reflexarc_trainer.policy.translation.shape_operators import SHAPE_RULES
from reflexarc_trainer.policy.translation.tracing import VARIES, measure_shapes, trace


def translate(
    module: nn.Module, inputs: dict[str, tuple[int, ...]], translation: Translation
) -> tuple[str, ...]:
    """Add the nodes of a module; returns the names of its outputs.

    Args:
        module: the module, in float64.
        inputs: name of each of its inputs in the graph, and its shape without the batch.
        translation: the graph.

    Raises:
        PolicyError: the module cannot be traced, or makes a call that is not in the table.
    """
    traced = trace(module, len(inputs))
    shapes = measure_shapes(traced, list(inputs.values()))
    values: dict[fx.Node, Any] = {}
    names = iter(inputs)
    for node in traced.graph.nodes:
        match node.op:
            case "placeholder":
                values[node] = Value(next(names), shapes[node])
            case "output":
                return _outputs(_filled(node.args[0], values))
            case "get_attr":
                values[node] = Value(_parameter(translation, traced, node), shapes[node])
            case _:
                values[node] = _called(translation, traced, node, values, shapes[node])
    raise PolicyError("export: the module returns nothing")


def _called(
    translation: Translation,
    traced: fx.GraphModule,
    node: fx.Node,
    values: dict[fx.Node, Any],
    result: Any,
) -> Any:
    if not _has_tensors(result):
        return result  # a size, or what was computed from sizes: it is known already
    if not node.args:
        raise PolicyError(f"export: {node.name}: give its inputs by position, not by keyword")
    module = traced.get_submodule(str(node.target)) if node.op == "call_module" else None
    args = [_filled(argument, values) for argument in node.args]
    kwargs = {key: _filled(argument, values) for key, argument in node.kwargs.items()}
    if node.target is operator.getitem and isinstance(args[0], tuple):
        return args[0][args[1]]
    rule = _rule(type(module) if module is not None else node.target, node)
    return _with_shapes(rule(Call(translation, module, args, kwargs, result)), result)


def _rule(key: Any, node: fx.Node) -> Rule:
    rule = _TABLE.get(key)
    if rule is None:
        name = getattr(key, "__name__", str(key))
        known = ", ".join(sorted({getattr(k, "__name__", str(k)) for k in _TABLE}))
        raise PolicyError(f"export: operator {name} ({node.name}) is not supported; known: {known}")
    return rule


def _filled(argument: Any, values: dict[fx.Node, Any]) -> Any:
    """An argument with values in place of the calls that they come from."""
    if isinstance(argument, fx.Node):
        return values[argument]
    if isinstance(argument, tuple | list):
        return tuple(_filled(part, values) for part in argument)
    if isinstance(argument, slice):
        ends = (argument.start, argument.stop, argument.step)
        return slice(*(_filled(part, values) for part in ends))
    return argument


def _has_tensors(result: Any) -> bool:
    if isinstance(result, Shape):
        return True
    return isinstance(result, tuple) and any(map(_has_tensors, result))


def _with_shapes(names: Names, shapes: Any) -> Any:
    if isinstance(names, str):
        return Value(names, shapes)
    return tuple(map(_with_shapes, names, shapes))


def _outputs(result: Any) -> tuple[str, ...]:
    values = result if isinstance(result, tuple) else (result,)
    return tuple(value.name for value in values)


def _parameter(translation: Translation, traced: fx.GraphModule, node: fx.Node) -> str:
    owner, _, name = str(node.target).rpartition(".")
    return translation.constant(name, weights(getattr(traced.get_submodule(owner), name)))


def _linear(call: Call) -> str:
    module, graph = call.module, call.graph
    if len(call.args[0].shape) != 2:
        return _linear_of_many(call)
    inputs = [call.args[0].name, graph.constant("weight", weights(module.weight))]
    if module.bias is not None:
        inputs.append(graph.constant("bias", weights(module.bias)))
    return graph.node("Gemm", inputs, transB=1)


def _linear_of_many(call: Call) -> str:
    """A layer over the last of several axes, which Gemm does not have."""
    module, graph = call.module, call.graph
    columns = np.ascontiguousarray(weights(module.weight).T)
    product = graph.node("MatMul", [call.args[0].name, graph.constant("weight", columns)])
    if module.bias is None:
        return product
    return graph.node("Add", [product, graph.constant("bias", weights(module.bias))])


def _same(call: Call) -> str:
    return str(call.args[0].name)


def _plain(kind: str) -> Rule:
    """An operator whose inputs are values or numbers, and that has no attributes."""

    def rule(call: Call) -> str:
        if any(key != "inplace" for key in call.kwargs):
            raise PolicyError(f"export: {kind} with {', '.join(call.kwargs)} is not supported")
        return call.graph.node(kind, [_named(call.graph, a) for a in call.args])

    return rule


def _named(translation: Translation, argument: Any) -> str:
    if isinstance(argument, Value):
        return argument.name
    if argument is VARIES:
        raise PolicyError("export: a number that depends on the size of the batch is not supported")
    return translation.constant("number", np.array(argument, np.float32))


_TABLE: dict[Any, Rule] = {
    **SHAPE_RULES,
    **RECURRENT_RULES,
    nn.Linear: _linear,
    # These add no node: the graph before the module divides by 255, and the others do nothing
    # in a network that is not being trained.
    intensity: _same,
    nn.Identity: _same,
    nn.Dropout: _same,
    "contiguous": _same,
    **dict.fromkeys(
        (nn.Sigmoid, torch.sigmoid, nn.functional.sigmoid, "sigmoid"), _plain("Sigmoid")
    ),
    **dict.fromkeys((nn.Tanh, torch.tanh, nn.functional.tanh, "tanh"), _plain("Tanh")),
    **dict.fromkeys((nn.ReLU, torch.relu, nn.functional.relu, "relu"), _plain("Relu")),
    **dict.fromkeys((operator.add, torch.add, "add"), _plain("Add")),
    **dict.fromkeys((operator.sub, torch.sub, "sub"), _plain("Sub")),
    **dict.fromkeys((operator.mul, torch.mul, "mul"), _plain("Mul")),
    **dict.fromkeys((operator.truediv, torch.div, "div"), _plain("Div")),
    **dict.fromkeys((operator.matmul, torch.matmul, "matmul"), _plain("MatMul")),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
