"""The NumPy backend: computes a policy's ONNX graph in float64, for a closed list of operators.

A small network computed in float64 from float32 weights and 8-bit inputs, and rounded once to
float32, gives the same bits for any order of summation and any vector width, except at ties of the
two roundings. So it is the reference: what it computed on one machine replays on another. A memory
is rounded with the Q-values, once a tick: what a log holds of it is what the next tick began with.

A graph is compiled once into a list of steps; running it makes one NumPy call for each node, but
for the recurrent ones, which make a few.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import onnx
from onnx import numpy_helper

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operator import Tensor
from reflexarc_runtime.policy.operators import OPERATORS
from reflexarc_runtime.policy.recurrent_operators import MANY_OPERATORS

_ABSENT = ""
"""How ONNX names an optional input that is not given, and an output that nobody wants."""


class GraphStep(NamedTuple):
    """One node of the graph: an operator, where its inputs lie and where its outputs go."""

    operator: Callable[..., Any]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    is_many: bool
    """Whether the operator returns a tuple, one for each output."""


class NumpyGraph:
    """Runs an exported policy graph with NumPy alone.

    Raises:
        PolicyError: the graph uses an operator that this backend does not have.
    """

    name = "numpy"

    def __init__(self, model: onnx.ModelProto) -> None:
        constants = {t.name: _constant(t) for t in model.graph.initializer}
        self._constants: dict[str, Any] = {_ABSENT: None, **constants}
        self._steps = [_compile(node) for node in model.graph.node]

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; stacks are (n, frames, eyes, rays, channels)."""
        values: dict[str, Any] = {**self._constants, "retina": retinas}
        if memories is not None:
            values["state"] = memories.astype(np.float64)
        with np.errstate(all="ignore"):  # what is not finite is a verdict, not a warning
            for operator, inputs, outputs, is_many in self._steps:
                result = operator(*[values[name] for name in inputs])
                if is_many:
                    _store(values, outputs, result)
                else:
                    values[outputs[0]] = result
            following = values.get("state_next")
            next_memories = None if following is None else following.astype(np.float32)
            return values["q_values"].astype(np.float32), values["action"], next_memories

    def end_run(self) -> None:
        """See `Graph.end_run`: none of its operators loops, so there is nothing to end."""


def supported_operators() -> tuple[str, ...]:
    """Names of the ONNX operators that the NumPy backend has."""
    return tuple(sorted((*OPERATORS, *MANY_OPERATORS)))


def _store(values: dict[str, Any], names: tuple[str, ...], results: tuple[Tensor, ...]) -> None:
    values.update((n, r) for n, r in zip(names, results, strict=False) if n != _ABSENT)


def _constant(tensor: onnx.TensorProto) -> Tensor:
    array: Tensor = numpy_helper.to_array(tensor)
    return array.astype(np.float64) if array.dtype.kind == "f" else array


def _compile(node: onnx.NodeProto) -> GraphStep:
    kind = node.op_type
    if kind not in supported_operators() or node.domain not in ("", "ai.onnx"):
        raise PolicyError(
            f"operator {kind} (node {node.name or node.output[0]!r}) is not in the NumPy "
            f"backend, which has {', '.join(supported_operators())}; use --backend onnxruntime"
        )
    is_many = kind in MANY_OPERATORS
    outputs = tuple(node.output) if is_many else (node.output[0],)
    return GraphStep(_operator(node), _inputs(node), outputs, is_many)


def _operator(node: onnx.NodeProto) -> Callable[..., Any]:
    kind = node.op_type
    attributes = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
    try:
        if kind in MANY_OPERATORS:
            return MANY_OPERATORS[kind](attributes, node)
        return OPERATORS[kind](attributes)
    except KeyError as error:
        raise PolicyError(f"operator {kind}: attribute {error} is missing") from None


def _inputs(node: onnx.NodeProto) -> tuple[str, ...]:
    """Names of the inputs; absent ones at the end are left to the operator's defaults."""
    names = list(node.input)
    while names and names[-1] == _ABSENT:
        names.pop()
    return tuple(names)
