"""Translation of a torch module to ONNX nodes, by one small table of rules.

`torch.fx` traces the module; each call of the trace is a module's class, a function or a method's
name, and the table says how it is written in ONNX. Others are refused by name, for replay needs
graphs that the NumPy reference can compute.
"""

import operator
from typing import Any

import numpy as np
from torch import fx, nn

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.activations import ACTIVATION_RULES
from reflexarc_trainer.policy.translation.arithmetic import ARITHMETIC_RULES
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
from reflexarc_trainer.policy.translation.reductions import REDUCTION_RULES
from reflexarc_trainer.policy.translation.shape_operators import SHAPE_RULES
from reflexarc_trainer.policy.translation.tracing import measure_shapes, trace
from reflexarc_trainer.policy.translation.windows import WINDOW_RULES

_FIELDS = ("values", "indices")


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
    if node.target is getattr and isinstance(args[0], tuple):
        return args[0][_FIELDS.index(args[1])]  # of what `x.max(dim)` returns
    rule = _rule(type(module) if module is not None else node.target, node)
    return _with_shapes(rule(Call(translation, module, args, kwargs, result)), result)


def _rule(key: Any, node: fx.Node) -> Rule:
    kinds = key.__mro__ if isinstance(key, type) else (key,)  # a weight norm makes a subclass
    rule = next((_TABLE[kind] for kind in kinds if kind in _TABLE), None)
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


_TABLE: dict[Any, Rule] = {
    **SHAPE_RULES,
    **ARITHMETIC_RULES,
    **ACTIVATION_RULES,
    **REDUCTION_RULES,
    **WINDOW_RULES,
    **RECURRENT_RULES,
    nn.Linear: _linear,
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
