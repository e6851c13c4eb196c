"""A policy's graph that has already been asked what a log says it will be asked next.

The NumPy backend gives the same bits for one retina as for many at once, and many at once cost a
tenth. What the controller asks that the log does not hold is computed when it asks.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from reflexarc_logs.replaying.loop_events import LoopEvent
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy

EVENTS_AHEAD = 512
BYTES_AHEAD = 4 << 20
"""Events that are read ahead, and the most that their messages hold."""


class AskedAhead:
    """A graph without a memory, asked ahead: see `Graph`.

    Args:
        policy: whose graph it is.
    """

    def __init__(self, policy: LoadedPolicy) -> None:
        self.name = policy.graph.name
        self._graph, self._shape = policy.graph, policy.contract.retina.stack_shape
        self._answers: dict[bytes, tuple[QValues, Actions]] = {}

    def run(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions, Memories | None]:
        """See `Graph.run`."""
        known = self._answers.get(retinas.tobytes()) if memories is None else None
        return self._graph.run(retinas, memories) if known is None else (*known, None)

    def end_run(self) -> None:
        """See `Graph.end_run`."""
        self._graph.end_run()

    def ask(self, stacks: Iterable[bytes]) -> None:
        """Forget what was asked before, and ask about these."""
        size = int(np.prod(self._shape))
        asked = [*dict.fromkeys(stack for stack in stacks if len(stack) == size)]
        self._answers = {}
        if not asked:
            return
        retinas = np.frombuffer(b"".join(asked), np.uint8).reshape(-1, *self._shape)
        try:
            q_values, winners, _ = self._graph.run(retinas, None)
        except Exception:  # whatever it does: each is computed when it is asked, as in the loop
            return
        for row, stack in enumerate(asked):
            self._answers[stack] = q_values[row : row + 1], winners[row : row + 1]


def asked_ahead(
    policy: LoadedPolicy, events: Iterator[LoopEvent]
) -> tuple[LoadedPolicy, Iterator[LoopEvent]]:
    """The policy and the events of a loop, so that the policy is asked ahead where it can be.

    Args:
        policy: whom the controller will ask.
        events: what the loop did.
    """
    if policy.backend is not Backend.NUMPY or policy.contract.state.size:
        return policy, events
    graph = AskedAhead(policy)
    return replace(policy, graph=graph), _read_ahead(events, graph)


def _read_ahead(events: Iterator[LoopEvent], graph: AskedAhead) -> Iterator[LoopEvent]:
    for part in _parts(events):
        graph.ask(event.decision.retina for event in part if isinstance(event, Tick))
        yield from part


def _parts(events: Iterator[LoopEvent]) -> Iterator[list[LoopEvent]]:
    part, held_bytes = list[LoopEvent](), 0
    for event in events:
        part.append(event)
        held_bytes += len(event.payload) if isinstance(event, Message) else 0
        if len(part) >= EVENTS_AHEAD or held_bytes >= BYTES_AHEAD:
            yield part
            part, held_bytes = [], 0
    yield part
