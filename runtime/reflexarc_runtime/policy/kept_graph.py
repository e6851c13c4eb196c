"""A graph for inputs of one shape: a list of calls whose arrays were made before.

One run with the plain operators says of each value which shape and type it has, and what is the
same at every run: constants, shapes, and views of other values need no call any more. What is left
writes into an array of its own. Where an operator is one function of NumPy's that takes the array
to write to, it is that call; where it is not, its result is copied. So the bits are those of the
plain operators.

What it is given and gives away is copied: nobody else holds its arrays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.policy.operators.graph_node import ABSENT, OnnxNode, Operator
from reflexarc_runtime.policy.operators.kept_calls import kept_calls

Call = Callable[[], object]
OF_SHAPE_ALONE = ("Shape", "Size")
"""Operators whose result hangs on how much there is, and not on what it is."""


class GraphStep(NamedTuple):
    """One node of the graph: an operator, where its inputs lie and where its outputs go."""

    operator: Operator
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    node: OnnxNode


@dataclass
class KeptGraph:
    """A compiled graph; not for two threads at once.

    Args:
        steps: the nodes in order; no shape in them may hang on what is seen.
        constants: values by name.
        retinas: of the shape that all others will have.
        memories: the same; None without memory.
    """

    steps: Sequence[GraphStep]
    constants: dict[str, Any]
    retinas: RetinaBatch
    memories: Memories | None
    _calls: list[Call] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.retinas = self.retinas.copy()
        self._values: dict[str, Any] = {**self.constants, "retina": self.retinas}
        self._varying = {"retina", "state"}
        if self.memories is not None:
            self._state = self.memories.astype(np.float64)
            self._values["state"] = self._state
        with np.errstate(all="ignore"):
            for step in self.steps:
                self._keep(step)
        self._q_values = self._values["q_values"]
        self._action = self._values["action"]
        self._following = self._values.get("state_next")

    def fits(self, retinas: RetinaBatch, memories: Memories | None) -> bool:
        """Whether it was compiled for these."""
        if retinas.shape != self.retinas.shape or retinas.dtype != self.retinas.dtype:
            return False
        if memories is None or self.memories is None:
            return memories is self.memories
        return memories.shape == self.memories.shape

    def run(
        self, retinas: RetinaBatch, memories: Memories | None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`; warnings of NumPy are left to the caller."""
        np.copyto(self.retinas, retinas)
        if memories is not None:
            np.copyto(self._state, memories)
        for call in self._calls:
            call()
        following = None if self._following is None else self._following.astype(np.float32)
        return self._q_values.astype(np.float32), self._action.copy(), following

    def _keep(self, step: GraphStep) -> None:
        given = [self._values[name] for name in step.inputs]
        results, calls = kept_calls(step.operator, step.node, given)
        named = zip(step.outputs, results, strict=False)
        self._values.update((name, made) for name, made in named if name != ABSENT)
        if step.node.kind not in OF_SHAPE_ALONE and not self._varying.isdisjoint(step.inputs):
            self._varying.update(step.outputs)
            self._calls += calls
