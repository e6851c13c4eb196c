"""Translation of a torch module to ONNX nodes, by one small table of operators.

`torch.fx` traces the module; each node of the trace is a module's class, a function or a method's
name, and the table says how it is written in ONNX. Other operators are refused by name, for replay
needs graphs that the NumPy reference can compute.
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
import torch
from onnx import helper, numpy_helper
from torch import Tensor, fx, nn

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.q_network import intensity


@dataclass
class Translation:
    """An ONNX graph under construction."""

    nodes: list[onnx.NodeProto] = field(default_factory=list)
    constants: list[onnx.TensorProto] = field(default_factory=list)

    def node(self, kind: str, inputs: list[str], output: str = "", **attributes: Any) -> str:
        """Add a node of an ONNX operator (`kind`); returns the name of its output."""
        output = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def constant(self, name: str, value: npt.NDArray[Any]) -> str:
        """Add a constant; returns its name."""
        name = f"{name}_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(value, name))
        return name


Emit: TypeAlias = Callable[[Translation, Any, list[Any], dict[str, Any]], str]
"""(graph, the module or None, arguments, keyword arguments) → name of the output."""


def translate(module: nn.Module, inputs: str, translation: Translation) -> str:
    """Add the nodes of a module; returns the name of its output.

    Args:
        module: the module.
        inputs: name of its input in the graph.
        translation: the graph.

    Raises:
        PolicyError: the module cannot be traced, or has an operator that is not in the table.
    """
    traced = _trace(module)
    names: dict[fx.Node, Any] = {}
    for node in traced.graph.nodes:
        match node.op:
            case "placeholder":
                names[node] = inputs
            case "output":
                return str(names[node.args[0]])
            case "get_attr":
                names[node] = _parameter(translation, traced, str(node.target))
            case _:
                names[node] = _emit(translation, traced, node, names)
    raise PolicyError("export: the module returns nothing")


def _trace(module: nn.Module) -> fx.GraphModule:
    try:
        traced = fx.symbolic_trace(module)
    except Exception as error:  # tracing runs the module's own code, which may raise anything
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise PolicyError(f"export: {type(module).__name__} cannot be traced: {reason}") from None
    placeholders = sum(node.op == "placeholder" for node in traced.graph.nodes)
    if placeholders != 1:
        raise PolicyError(f"export: expected a module of one input, got {placeholders}")
    return traced


def _emit(
    translation: Translation, traced: fx.GraphModule, node: fx.Node, names: dict[fx.Node, Any]
) -> str:
    module = traced.get_submodule(str(node.target)) if node.op == "call_module" else None
    key = type(module) if module is not None else node.target
    emit = _TABLE.get(key)
    if emit is None:
        name = getattr(key, "__name__", str(key))
        known = ", ".join(sorted({getattr(k, "__name__", str(k)) for k in _TABLE}))
        raise PolicyError(f"export: operator {name} ({node.name}) is not supported; known: {known}")
    if not node.args:
        raise PolicyError(f"export: {node.name}: give its inputs by position, not by keyword")
    args = [names[a] if isinstance(a, fx.Node) else a for a in node.args]
    kwargs = {k: names[a] if isinstance(a, fx.Node) else a for k, a in node.kwargs.items()}
    return emit(translation, module, args, kwargs)


def _parameter(translation: Translation, traced: fx.GraphModule, target: str) -> str:
    owner, _, name = target.rpartition(".")
    return translation.constant(name, _array(getattr(traced.get_submodule(owner), name)))


def _array(tensor: Tensor) -> npt.NDArray[np.float32]:
    array: npt.NDArray[np.float32] = tensor.detach().float().numpy()
    return array


def _linear(translation: Translation, module: Any, args: list[Any], _: dict[str, Any]) -> str:
    inputs = [args[0], translation.constant("weight", _array(module.weight))]
    if module.bias is not None:
        inputs.append(translation.constant("bias", _array(module.bias)))
    return translation.node("Gemm", inputs, transB=1)


def _flatten(translation: Translation, module: Any, args: list[Any], kwargs: dict[str, Any]) -> str:
    given = {"start_dim": 0, "end_dim": -1}
    if module is not None:
        given = {"start_dim": module.start_dim, "end_dim": module.end_dim}
    given |= dict(zip(given, args[1:], strict=False)) | kwargs
    if given != {"start_dim": 1, "end_dim": -1}:
        raise PolicyError(f"export: flatten with {given} is not supported; use flatten(x, 1)")
    return translation.node("Flatten", [args[0]], axis=1)


def _same(_: Translation, __: Any, args: list[Any], ___: dict[str, Any]) -> str:
    return str(args[0])


def _plain(kind: str) -> Emit:
    """An operator whose inputs are values or numbers, and that has no attributes."""

    def emit(translation: Translation, _: Any, args: list[Any], kwargs: dict[str, Any]) -> str:
        if any(key != "inplace" for key in kwargs):
            raise PolicyError(f"export: {kind} with {', '.join(kwargs)} is not supported")
        return translation.node(kind, [_value(translation, a) for a in args])

    return emit


def _value(translation: Translation, argument: Any) -> str:
    if isinstance(argument, str):
        return argument
    return translation.constant("number", np.array(argument, np.float32))


_TABLE: dict[Any, Emit] = {
    nn.Linear: _linear,
    nn.Flatten: _flatten,
    torch.flatten: _flatten,
    "flatten": _flatten,
    # These add no node: the graph before the module divides by 255, and the other two do nothing
    # in a network that is not being trained.
    intensity: _same,
    nn.Identity: _same,
    nn.Dropout: _same,
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
"""Class, function or method name of a traced node → what adds its ONNX nodes."""
