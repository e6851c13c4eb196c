"""Rules for torch's recurrent modules: GRU, LSTM and their single cells.

A torch layer computes what one ONNX node does, but for the order of its gates:

    torch GRU   r z n     ONNX z r h, with linear_before_reset = 1
    torch LSTM  i f g o   ONNX i o f c

A cell is a layer over a sequence of one.
"""

from typing import Any

import numpy as np
from torch import nn

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import (
    Call,
    Names,
    Rule,
    Translation,
    Value,
)
from reflexarc_trainer.policy.translation.parameters import weights

_GATES = {"GRU": (1, 0, 2), "LSTM": (0, 3, 1, 2)}
"""Which gate of torch's is the first, second, … of ONNX."""
_ATTRIBUTES: dict[str, dict[str, Any]] = {"GRU": {"linear_before_reset": 1}, "LSTM": {}}
_PARTS = {"GRU": 1, "LSTM": 2}
"""Tensors that are remembered: h, or h and c."""


def _layers(call: Call) -> Names:
    """`nn.GRU` and `nn.LSTM`: (x, memory) → (y, memory)."""
    _check(call)
    graph, module, kind = call.graph, call.module, call.module.mode
    x, ends = _steps_first(call, call.args[0].name), []
    memory = _memory(call)
    for layer in range(module.num_layers):
        start = [_row(graph, part, layer, module.num_layers) for part in memory]
        y, *end = _layer(graph, module, kind, f"_l{layer}", x, start)
        x = graph.node("Squeeze", [y, graph.integers("axes", 1)])
        ends.append(end)
    joined = tuple(_joined(graph, list(parts)) for parts in zip(*ends, strict=True))
    return _steps_first(call, x), joined if kind == "LSTM" else joined[0]


def _cell(kind: str) -> Rule:
    """`nn.GRUCell` and `nn.LSTMCell`: (x, memory) → memory."""

    def rule(call: Call) -> Names:
        graph, axes = call.graph, call.graph.integers("axes", 0)
        x, *start = (
            graph.node("Unsqueeze", [name, axes]) for name in (call.args[0].name, *_memory(call))
        )
        _, *end = _layer(graph, call.module, kind, "", x, start)
        names = tuple(graph.node("Squeeze", [part, axes]) for part in end)
        return names if kind == "LSTM" else names[0]

    return rule


def _layer(
    graph: Translation, module: Any, kind: str, suffix: str, x: str, start: list[str]
) -> tuple[str, ...]:
    """One ONNX node: the h of every step (steps, 1, n, size), then what is remembered."""
    inputs = [x, _gates(graph, module, kind, f"weight_ih{suffix}")]
    inputs.append(_gates(graph, module, kind, f"weight_hh{suffix}"))
    inputs.append(_biases(graph, module, kind, suffix) if module.bias else "")
    if start:
        inputs += ["", *start]
    return graph.many(
        kind, inputs, 1 + _PARTS[kind], hidden_size=module.hidden_size, **_ATTRIBUTES[kind]
    )


def _gates(graph: Translation, module: Any, kind: str, name: str) -> str:
    return graph.constant(name, _reordered(module, kind, name)[np.newaxis])


def _biases(graph: Translation, module: Any, kind: str, suffix: str) -> str:
    both = [_reordered(module, kind, f"bias_{of}{suffix}") for of in ("ih", "hh")]
    return graph.constant(f"bias{suffix}", np.concatenate(both)[np.newaxis])


def _reordered(module: Any, kind: str, name: str) -> Any:
    order = _GATES[kind]
    gates = np.split(weights(getattr(module, name)), len(order))
    return np.concatenate([gates[index] for index in order])


def _memory(call: Call) -> list[str]:
    """Names of the tensors that are remembered; none: zeros."""
    memory = call.given("hx", hx=None)["hx"]
    if memory is None:
        return []
    parts: tuple[Value, ...] = memory if isinstance(memory, tuple) else (memory,)
    return [part.name for part in parts]


def _steps_first(call: Call, name: str) -> str:
    """With the sequence before the batch, or back again: two axes are swapped."""
    return call.graph.node("Transpose", [name], perm=[1, 0, 2]) if call.module.batch_first else name


def _row(graph: Translation, part: str, layer: int, layers: int) -> str:
    if layers == 1:
        return part
    ends = [graph.integers(word, layer + index) for index, word in enumerate(("starts", "ends"))]
    return graph.node("Slice", [part, *ends, graph.integers("axes", 0)])


def _joined(graph: Translation, parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else graph.node("Concat", parts, axis=0)


def _check(call: Call) -> None:
    module, shape = call.module, call.args[0].shape
    name = type(module).__name__
    if module.bidirectional:
        raise PolicyError(f"export: {name}: bidirectional=True is not supported: it needs a future")
    if module.proj_size:
        raise PolicyError(f"export: {name}: proj_size={module.proj_size} is not supported; use 0")
    batch = 0 if module.batch_first else 1
    if len(shape) != 3 or shape[batch] is not None:
        wanted = "(n, steps, inputs)" if module.batch_first else "(steps, n, inputs)"
        raise PolicyError(
            f"export: {name}: expected an input {wanted} for batch_first={module.batch_first}, "
            f"got {_words(shape)}; check batch_first"
        )


def _words(shape: tuple[int | None, ...]) -> str:
    return f"({', '.join('n' if size is None else str(size) for size in shape)})"


RECURRENT_RULES: dict[Any, Rule] = {
    nn.GRU: _layers,
    nn.LSTM: _layers,
    nn.GRUCell: _cell("GRU"),
    nn.LSTMCell: _cell("LSTM"),
}
"""Class of a traced module → what writes it in ONNX."""
