"""The NumPy backend: computes a policy's ONNX graph in float64, for a closed list of operators.

A small network computed in float64 from float32 weights and 8-bit inputs, and rounded once to
float32, gives the same bits for any order of summation and any vector width, except at ties of the
two roundings. So it is the reference: what it computed on one machine replays on another. A memory
is rounded with the Q-values, once a tick: what a log holds of it is what the next tick began with.

A graph is compiled once into a list of steps; running it makes one NumPy call for each node, but
for the recurrent ones, which make a few. For one decision at a time, as a loop makes them, it is
compiled further, into calls over arrays that are kept: see `kept_graph`.
"""

from typing import Any

import numpy as np
import onnx

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.kept_graph import OF_SHAPE_ALONE, GraphStep, KeptGraph
from reflexarc_runtime.policy.numpy_limits import (
    ELEMENTS_AT_ONCE,
    ELEMENTS_OF_ONE,
    SHAPE_INPUTS,
    Meter,
)
from reflexarc_runtime.policy.operators.graph_node import (
    ABSENT,
    LATEST_OPSET,
    OLDEST_OPSET,
    ONNX_DOMAINS,
    Tensor,
    array_of,
)
from reflexarc_runtime.policy.operators.operator_table import (
    compiled,
    supported_operators,
)

__all__ = ["GraphStep", "NumpyGraph", "supported_operators"]


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
        self._rows_at_once = 0
        """How many decisions are computed together; 0 while it is not known."""
        self._measured: set[int] = set()
        """Numbers of decisions whose cost has been found small enough."""
        self._has_fixed_shapes = not _shapes_hang_on_inputs(self._steps)
        self._for_one: list[KeptGraph] = []
        """The graph for one decision: none before the first, as many as threads that decide."""

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; stacks are (n, frames, eyes, rays, channels).

        Raises:
            PolicyError: a decision would take more memory or work than `numpy_limits` allows.
        """
        if len(retinas) == 1:
            decided = self._decide_one(retinas, memories)
            if decided is not None:
                return decided
        if not self._rows_at_once:
            self._rows_at_once = self._find_rows_at_once(retinas, memories)
        count, most = len(retinas), self._rows_at_once
        if count <= most:
            answer = self._compute(retinas, memories)
            if count == 1 and self._has_fixed_shapes and not self._for_one:
                kept = KeptGraph(self._steps, self._constants, retinas, memories)
                self._for_one.append(kept)
            return answer
        starts = range(0, count, most)
        parts = [
            self._compute(
                retinas[start : start + most],
                None if memories is None else memories[start : start + most],
            )
            for start in starts
        ]
        return _joined(parts)

    def end_run(self) -> None:
        """See `Graph.end_run`: none of its operators loops, so there is nothing to end."""

    def _decide_one(
        self, retinas: RetinaBatch, memories: Memories | None
    ) -> tuple[QValues, Actions, Memories | None] | None:
        """Over kept arrays; None where they are in use by another thread, or of another shape."""
        try:
            graph = self._for_one.pop()  # so whoever has it has it alone
        except IndexError:
            return None
        try:
            if not graph.fits(retinas, memories):
                return None
            with np.errstate(all="ignore"):
                return graph.run(retinas, memories)
        finally:
            self._for_one.append(graph)

    def _find_rows_at_once(self, retinas: RetinaBatch, memories: Memories | None) -> int:
        """Compute one decision and count what it takes."""
        one = np.zeros((1, *retinas.shape[1:]), retinas.dtype)
        its = None if memories is None else np.zeros((1, *memories.shape[1:]), memories.dtype)
        meter = Meter(ELEMENTS_OF_ONE, 1)
        self._compute(one, its, meter)
        return max(1, ELEMENTS_AT_ONCE // max(1, meter.made))

    def _meter_for(self, count: int) -> Meter | None:
        """None where the cost is known: it hangs on the number of decisions alone."""
        if self._has_fixed_shapes and count in self._measured:
            return None
        self._measured.add(count)
        return Meter(ELEMENTS_OF_ONE if count == 1 else ELEMENTS_AT_ONCE, count)

    def _compute(
        self, retinas: RetinaBatch, memories: Memories | None, meter: Meter | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        meter = meter or self._meter_for(len(retinas))
        values: dict[str, Any] = {**self._constants, "retina": retinas}
        if memories is not None:
            values["state"] = memories.astype(np.float64)
        with np.errstate(all="ignore"):  # what is not finite is a verdict, not a warning
            for operator, inputs, outputs, node in self._steps:
                given = [values[name] for name in inputs]
                if meter is not None:
                    meter.count(node, given)
                result = operator(*given)
                if isinstance(result, tuple):
                    _store(values, outputs, result)
                else:
                    values[outputs[0]] = result
            following = values.get("state_next")
            next_memories = None if following is None else following.astype(np.float32)
            return values["q_values"].astype(np.float32), values["action"], next_memories


def _store(values: dict[str, Any], names: tuple[str, ...], results: tuple[Tensor, ...]) -> None:
    values.update((n, r) for n, r in zip(names, results, strict=False) if n != ABSENT)


def _step(node: onnx.NodeProto, opset: int) -> GraphStep:
    form, operator = compiled(node, opset)
    return GraphStep(operator, form.inputs, form.outputs, form)


def _shapes_hang_on_inputs(steps: list[GraphStep]) -> bool:
    """Whether a shape in the graph hangs on what is seen, and not on how much of it there is."""
    hanging = {"retina", "state"}
    for step in steps:
        said = step.inputs[SHAPE_INPUTS.get(step.node.kind, slice(0, 0))]
        if not hanging.isdisjoint(said):
            return True
        if step.node.kind not in OF_SHAPE_ALONE and not hanging.isdisjoint(step.inputs):
            hanging.update(step.outputs)
    return False


def _joined(
    parts: list[tuple[QValues, Actions, Memories | None]],
) -> tuple[QValues, Actions, Memories | None]:
    q_values, actions = (np.concatenate([part[i] for part in parts]) for i in range(2))
    memories = [part[2] for part in parts if part[2] is not None]
    return q_values, actions, np.concatenate(memories) if memories else None


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
