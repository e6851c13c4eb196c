"""The NumPy backend: computes a policy's ONNX graph in float64, for a closed list of operators.

A small network computed in float64 from float32 weights and 8-bit inputs, and rounded once to
float32, gives the same bits for any order of summation and any vector width, except at ties of the
two roundings. So it is the reference: what it computed on one machine replays on another. A memory
is rounded with the Q-values, once a tick: what a log holds of it is what the next tick began with.

A graph is compiled once into a list of steps; running it makes one NumPy call for each node, but
for the recurrent ones, which make a few.
"""

from typing import Any, NamedTuple

import numpy as np
import onnx

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.graph_node import (
    ABSENT,
    LATEST_OPSET,
    OLDEST_OPSET,
    ONNX_DOMAINS,
    Operator,
    Tensor,
    array_of,
)
from reflexarc_runtime.policy.operators.operator_table import (
    given_inputs,
    operator_of,
    supported_operators,
)

__all__ = ["GraphStep", "NumpyGraph", "supported_operators"]


class GraphStep(NamedTuple):
    """One node of the graph: an operator, where its inputs lie and where its outputs go."""

    operator: Operator
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


class NumpyGraph:
    """Runs an exported policy graph with NumPy alone.

    Raises:
        PolicyError: the graph uses an operator that this backend does not have.
    """

    name = "numpy"

    def __init__(self, model: onnx.ModelProto) -> None:
        opset = _opset(model)
        constants = {t.name: array_of(t) for t in model.graph.initializer}
        self._constants: dict[str, Any] = {ABSENT: None, **constants}
        self._steps = [_step(node, opset) for node in model.graph.node]

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; stacks are (n, frames, eyes, rays, channels)."""
        values: dict[str, Any] = {**self._constants, "retina": retinas}
        if memories is not None:
            values["state"] = memories.astype(np.float64)
        with np.errstate(all="ignore"):  # what is not finite is a verdict, not a warning
            for operator, inputs, outputs in self._steps:
                result = operator(*[values[name] for name in inputs])
                if isinstance(result, tuple):
                    _store(values, outputs, result)
                else:
                    values[outputs[0]] = result
            following = values.get("state_next")
            next_memories = None if following is None else following.astype(np.float32)
            return values["q_values"].astype(np.float32), values["action"], next_memories

    def end_run(self) -> None:
        """See `Graph.end_run`: none of its operators loops, so there is nothing to end."""


def _store(values: dict[str, Any], names: tuple[str, ...], results: tuple[Tensor, ...]) -> None:
    values.update((n, r) for n, r in zip(names, results, strict=False) if n != ABSENT)


def _step(node: onnx.NodeProto, opset: int) -> GraphStep:
    return GraphStep(operator_of(node, opset), given_inputs(node), tuple(node.output))


def _opset(model: onnx.ModelProto) -> int:
    """The version of the operator set, which says what a node means."""
    versions = [o.version for o in model.opset_import if o.domain in ONNX_DOMAINS]
    version = versions[0] if versions else 0
    if not OLDEST_OPSET <= version <= LATEST_OPSET:
        raise PolicyError(
            f"its operators are of set {version}; the NumPy backend knows sets {OLDEST_OPSET} to "
            f"{LATEST_OPSET}: export it with another opset, or use --backend onnxruntime"
        )
    return version
