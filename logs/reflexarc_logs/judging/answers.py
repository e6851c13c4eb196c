"""What a candidate answers to the retinas of a log, batch by batch.

The recorded policy and policies without a memory are asked in batches: a tick holds the memory that
the recorded one was given. Another policy with a memory is asked in order, from its start value;
until that has warmed up its answers do not count.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_logs.replaying.policy_level import Asked, CandidateMemory
from reflexarc_logs.replaying.recorded_holds import RecordedHolds
from reflexarc_logs.replaying.stepping import WARM_UP_NS
from reflexarc_runtime.arrays import Memories, QValues
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import LoadedPolicy

_BATCH_BYTES = 8 << 20
_BATCH_TICKS = 256


class JudgedTick(NamedTuple):
    """A tick at which the recorded policy was asked."""

    decision: Decision
    after_ns: int
    """Since the log's first tick."""
    counts: bool
    """Whether it lies in the window."""


class Answers(NamedTuple):
    """A batch of ticks, and the candidate's answers to them."""

    ticks: Sequence[JudgedTick]
    q_values: QValues
    winners: npt.NDArray[np.int64]
    is_warm: bool


class Answering:
    """A candidate that is asked about a log.

    Args:
        candidate: whom to ask.
        same_policy: whether it is the recorded one.
    """

    def __init__(self, candidate: LoadedPolicy, *, same_policy: bool) -> None:
        self._candidate, contract = candidate, candidate.contract
        self._remembers = contract.state.size > 0
        self._memory = CandidateMemory(candidate) if self._remembers and not same_policy else None
        self._holds, self._begins = RecordedHolds(contract), True
        self._first_ns: int | None = None
        bytes_a_tick = contract.retina.frames * contract.retina.size
        self._most = 1 if self._memory else min(max(1, _BATCH_BYTES // bytes_a_tick), _BATCH_TICKS)
        self._batch: list[JudgedTick] = []

    @property
    def needs_every_tick(self) -> bool:
        """Whether a tick outside of the window has to be asked about as well, and in order."""
        return self._memory is not None

    def passes(self, decision: Decision) -> None:
        """Take note of a tick, once it was asked about or was found to need no answer."""
        if self._memory is not None:
            self._begins = not self._holds.saw(decision)

    def ask(self, tick: JudgedTick) -> Iterator[Answers]:
        """Take a tick; answers come when a batch is full."""
        self._batch.append(tick)
        if len(self._batch) >= self._most:
            yield self._answers()

    def end(self) -> Iterator[Answers]:
        """The answers to what is left."""
        if self._batch:
            yield self._answers()

    def _answers(self) -> Answers:
        ticks, self._batch = self._batch, []
        if self._memory is not None:
            return self._answer_in_order(self._memory, ticks)
        contract = self._candidate.contract
        decisions = [one.decision for one in ticks]
        flat = np.frombuffer(b"".join(d.retina for d in decisions), np.uint8)
        stacks = flat.reshape(len(ticks), *contract.retina.stack_shape)
        if self._remembers:
            memories = _recorded_memories(decisions, contract)
            q_values, winners, _ = self._candidate.decide(stacks, memories)
        else:
            q_values, winners = self._candidate.decide(stacks)
        return Answers(ticks, q_values, winners, is_warm=True)

    def _answer_in_order(self, memory: CandidateMemory, ticks: Sequence[JudgedTick]) -> Answers:
        """One tick: a batch is no larger."""
        decision = ticks[0].decision
        known = self._holds.are_known(decision)
        begins = self._begins or self._holds.misses
        values, winner = memory.decide(Asked(decision, self._holds.held, known, begins))
        if self._first_ns is None:
            self._first_ns = decision.now_ns
        is_warm = decision.now_ns - self._first_ns >= WARM_UP_NS
        return Answers(ticks, values[np.newaxis], np.array([winner]), is_warm)


def _recorded_memories(decisions: Sequence[Decision], contract: PolicyContract) -> Memories:
    start, size = contract.state.start_value, contract.state.size
    rows = [d.state if len(d.state) == size else start for d in decisions]
    return np.array(rows, np.float32)
