"""The calls that a torch module makes, with the shape of what each returns.

`torch.fx` runs the module once with stand-ins and writes down its calls. Shapes are then measured:
the calls are made for a batch of two and for a batch of three, and a size that differs is the size
of the batch.
"""

from typing import Any

import torch
from torch import Tensor, fx, nn

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import Shape

BATCHES = (2, 3)
"""Not 1, which torch stretches and squeezes as it needs."""

_FLOAT_CASTS = ("float", "half", "bfloat16")


class _Varies:
    """Stands for a number that depends on the size of the batch."""


VARIES = _Varies()


def trace(module: nn.Module, inputs: int) -> fx.GraphModule:
    """Write down the calls of a module that takes so many tensors.

    Raises:
        PolicyError: it cannot be traced, or takes another number of tensors.
    """
    try:
        traced = fx.symbolic_trace(module)
    except Exception as error:  # tracing runs the module's own code, which may raise anything
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise PolicyError(f"export: {type(module).__name__} cannot be traced: {reason}") from None
    _compute_in_double(traced)
    placeholders = sum(node.op == "placeholder" for node in traced.graph.nodes)
    if placeholders != inputs:
        wanted = "one input" if inputs == 1 else f"{inputs} inputs (x, state)"
        raise PolicyError(f"export: expected a module of {wanted}, got {placeholders}")
    return traced


def measure_shapes(traced: fx.GraphModule, shapes: list[tuple[int, ...]]) -> dict[fx.Node, Any]:
    """What each call returns: the `Shape` of a tensor, a tuple of them, or a plain value.

    Args:
        traced: the calls.
        shapes: of each input of the module, without the batch.
    """
    first, second = (_results(traced, shapes, batch) for batch in BATCHES)
    return {node: _described(first[node], second[node]) for node in first}


def without_casts(module: nn.Module) -> nn.Module:
    """The module with its own changes of precision undone, so that it computes in float64.

    What cannot be traced is given back as it is.
    """
    try:
        traced = fx.symbolic_trace(module)
    except Exception:  # `trace` says why
        return module
    return traced.eval() if _compute_in_double(traced) else module


def _compute_in_double(traced: fx.GraphModule) -> bool:
    """Let casts to floats be casts to float64, tensors of the code too; whether there were any."""
    casts = [node for node in traced.graph.nodes if _is_float_cast(node)]
    for node in casts:
        node.target, node.args, node.kwargs = "double", node.args[:1], {}
    traced.recompile()
    return bool(casts) | _widen(traced)


def _widen(traced: fx.GraphModule) -> bool:
    """Turn floats that the module's code made, and that no parameter holds, into float64."""
    singles = {
        str(node.target)
        for node in traced.graph.nodes
        if node.op == "get_attr" and getattr(traced, str(node.target), None) is not None
    }
    found = [name for name in singles if getattr(traced, name).dtype == torch.float32]
    for name in found:
        setattr(traced, name, getattr(traced, name).double())
    return bool(found)


def _is_float_cast(node: fx.Node) -> bool:
    if node.op != "call_method":
        return False
    given = [*node.args[1:], *node.kwargs.values()]
    to_float = any(isinstance(each, torch.dtype) and each.is_floating_point for each in given)
    return node.target in _FLOAT_CASTS or (node.target in ("to", "type") and to_float)


class _Recorder(fx.Interpreter):
    """Makes the calls, and keeps what each returned."""

    def __init__(self, traced: fx.GraphModule) -> None:
        super().__init__(traced)
        self.results: dict[fx.Node, Any] = {}

    def run_node(self, n: fx.Node) -> Any:
        self.results[n] = super().run_node(n)
        return self.results[n]


def _results(
    traced: fx.GraphModule, shapes: list[tuple[int, ...]], batch: int
) -> dict[fx.Node, Any]:
    recorder = _Recorder(traced)
    with torch.no_grad():
        recorder.run(*(torch.zeros(batch, *shape, dtype=torch.float64) for shape in shapes))
    return recorder.results


def _described(first: Any, second: Any) -> Any:
    if isinstance(first, Tensor):
        pairs = zip(first.shape, second.shape, strict=True)
        return Shape(a if a == b else None for a, b in pairs)
    if isinstance(first, tuple | list) and not isinstance(first, torch.Size):
        return tuple(map(_described, first, second))
    if isinstance(first, torch.Size):
        return tuple(a if a == b else VARIES for a, b in zip(first, second, strict=True))
    return first if first == second else VARIES
