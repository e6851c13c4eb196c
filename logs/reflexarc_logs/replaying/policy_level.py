"""Replay at level `policy`: each tick's retinas through the policy, and what became of its choice.

Ticks at which the policy was not asked have no Q-values and are not compared. The recorded policy
is asked in batches: a tick holds its memory as well. Another policy with a memory is asked in
order, from its start value; what it says while that warms up does not count.

Holds and margins are judged tick by tick, in order: given what was done before, would this action
have been done?
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.comparison import (
    EqualityRules,
    Tally,
    find_flip,
    is_at_the_edge,
)
from reflexarc_logs.replaying.message_fields import Difference, message_type
from reflexarc_logs.replaying.recorded_holds import ASKED_VALUES
from reflexarc_logs.replaying.report import LevelResult
from reflexarc_logs.replaying.runs.asking import Asked, AskedTicks
from reflexarc_logs.replaying.runs.run_comparison import (
    AskedRun,
    JudgedPart,
    batch_size,
    decide_part,
    judge_part,
)
from reflexarc_logs.replaying.serving.policy_turns import PolicyTurn, turns_of
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.stepping import WARM_UP_NS
from reflexarc_runtime.arrays import Memories, QValues, RetinaBatch
from reflexarc_runtime.choice import choose
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages_pb2 import Decision, Tick
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.policy.policy import LoadedPolicy

__all__ = ["Asked", "CandidateMemory", "PolicyLevel", "replay_policy"]

GIVEN = ("slot", "retina", "state")
"""What the policy was asked, and when."""

_OK = Verdict.OK.value


def replay_policy(
    log: Log,
    policy: LoadedPolicy,
    rules: EqualityRules,
    ticks: Iterable[Tick | TickRun] | None = None,
    robot: str = "",
    served: ServedPolicies | None = None,
) -> LevelResult:
    """Ask the policy again about every tick at which it was asked.

    Where policies were swapped, each is asked about its own ticks; a candidate about all.

    Args:
        log: what was recorded.
        policy: whom to ask.
        rules: what counts as equal.
        ticks: those of the log that count; all of them if None.
        robot: see `LevelResult.robot`.
        served: who took over; by default, as the log says.

    Raises:
        LogError: the log cannot be read, or its retinas are not those of this policy.
    """
    tally = Tally("policy", rules, robot=robot)
    served = served or ServedPolicies(log, policy)
    found = log.ticks() if ticks is None else ticks
    if not served.are_followed:
        _compare(log, policy, tally, PolicyTurn("", None, iter(found)))
        return tally.result(given=GIVEN)
    for turn in turns_of(found, log.run.policy_hash):
        asked = served.of(turn.policy_hash)
        if asked is None:  # `LogAccount` says so
            continue
        _compare(log, asked, tally, turn)
    return tally.result(given=GIVEN)


def _compare(log: Log, policy: LoadedPolicy, tally: Tally, turn: PolicyTurn) -> None:
    """Ask a policy about its turn."""
    level = PolicyLevel(policy, tally, has_winner=_has_winner(log))
    asking = AskedTicks(log, policy.contract, tally, turn.begins)
    if policy.contract.state.size and not tally.rules.same_policy:
        level.compare_in_order(asking.one_by_one(turn.ticks))
        return
    for batch in asking.batches(turn.ticks):
        if isinstance(batch, AskedRun):
            level.compare_run(batch)
        else:
            level.compare(batch)


def _has_winner(log: Log) -> bool:
    """Whether ticks say what the policy preferred; before, it was always what was done."""
    return "winner" in message_type(log.tick_descriptor(), "decision").fields_by_name


@dataclass
class PolicyLevel:
    """A policy that is asked again, and the counts of what it said."""

    policy: LoadedPolicy
    tally: Tally
    has_winner: bool

    def compare(self, batch: Sequence[Asked]) -> None:
        """Compare ticks, each given the memory that was recorded."""
        if not batch:
            return
        contract = self.policy.contract
        stacks = _stack([one.decision for one in batch], contract)
        if contract.state.size:
            memories = _recorded_memories(batch, contract)
            q_values, winners, _ = self.policy.decide(stacks, memories)
        else:
            q_values, winners = self.policy.decide(stacks)
        recorded: QValues = np.array([one.decision.q_values for one in batch], np.float32)
        same = (recorded.view(np.uint32) == q_values.view(np.uint32)).all(axis=1).tolist()
        for row, (one, winner) in enumerate(zip(batch, winners.tolist(), strict=True)):
            differences = (
                [] if same[row] else list(_value_differences(recorded[row], q_values[row]))
            )
            self._add(one, q_values[row], winner, differences)

    def compare_run(self, asked: AskedRun) -> None:
        """Compare ticks that are all alike; one by one only those of which there is more to say."""
        contract, size = self.policy.contract, batch_size(self.policy.contract)
        for start in range(0, len(asked.run), size):
            part = slice(start, start + size)
            q_values, winners = decide_part(self.policy, asked.run, part)
            given = asked, part, q_values, winners, self.tally.rules, contract
            found = judge_part(*given, has_winner=self.has_winner)
            self._count_part(asked, start, found, q_values, winners.tolist())

    def _count_part(
        self, asked: AskedRun, start: int, found: JudgedPart, q_values: QValues, winners: list[int]
    ) -> None:
        alone = found.alone(has_first=self.tally.first is not None)
        for row in alone:
            one = Asked(
                asked.run.tick(start + row).decision, asked.held.at(start + row), True, False
            )
            values = np.array(one.decision.q_values, np.float32)
            differences = list(_value_differences(values, q_values[row]))
            self._add(one, q_values[row], winners[row], differences)
        rest = len(winners) - len(alone)
        identical = int(np.count_nonzero(found.identical)) - sum(map(found.is_identical, alone))
        self.tally.add_alike(rest, 2 + self.has_winner, identical)

    def compare_in_order(self, asked: Iterator[Asked]) -> None:
        """Compare ticks, with a memory of the policy's own."""
        first_ns: int | None = None
        memory = CandidateMemory(self.policy)
        for one in asked:
            now_ns = one.decision.now_ns
            first_ns = now_ns if first_ns is None else first_ns
            values, winner = memory.decide(one)
            if now_ns - first_ns < WARM_UP_NS:
                self.tally.warming_up += 1
            else:
                recorded = np.array(one.decision.q_values, np.float32)
                self._add(one, values, winner, list(_value_differences(recorded, values)))

    def _add(self, one: Asked, values: QValues, winner: int, differences: list[Difference]) -> None:
        """Compare one tick: values (actions,), how they differ, and the winner."""
        decision = one.decision
        action = decision.action
        was = decision.winner if self.has_winner else action
        flip = None
        if was != winner and (was >= 0 or self._has_to_win(decision)):
            tolerance = self.tally.rules.tolerance
            flip = find_flip(decision.index, decision.q_values, was, winner, tolerance)
            name = "winner" if self.has_winner else "action"
            differences.append(Difference(name, str(was), str(winner)))
        # What a guard did instead is judged at level `node`, which has what the guard saw.
        if self.has_winner and one.is_hold_known and decision.verdict == _OK:
            differences += self._action_differences(one, values, winner)
        self.tally.add(decision.index, 2 + self.has_winner, differences, flip)

    def _has_to_win(self, decision: Decision) -> bool:
        """Whether some action was preferred: none is where the policy failed."""
        return self.has_winner and decision.verdict in ASKED_VALUES

    def _action_differences(self, one: Asked, values: QValues, winner: int) -> list[Difference]:
        contract, slot, now = self.policy.contract, one.decision.slot, winner
        if contract.keeps_actions:
            least = contract.hold_slots, contract.margin, contract.least_lead
            now = choose(one.held, values.tolist(), winner, slot, *least).action
        if now == one.decision.action or self._is_at_the_edge(one, winner):
            return []
        return [Difference("action", str(one.decision.action), str(now))]

    def _is_at_the_edge(self, one: Asked, winner: int) -> bool:
        """Whether a margin is won or missed by the rounding of two backends only."""
        contract, rules, held = self.policy.contract, self.tally.rules, one.held
        if rules.exact or held is None or not (contract.margin or contract.least_lead):
            return False
        q_values = one.decision.q_values
        lead = q_values[winner] - q_values[held.action]
        return is_at_the_edge(q_values, lead, contract, rules.tolerance)


class CandidateMemory:
    """What a policy would have remembered of a log that another one drove."""

    def __init__(self, policy: LoadedPolicy) -> None:
        self._policy = policy
        self._memory = self._following = self._start()
        self._input = (-1, -1)

    def decide(self, one: Asked) -> tuple[QValues, int]:
        """Q-values (actions,) and the winner; a newer input commits what it remembers."""
        if one.begins:
            self._memory = self._following = self._start()
        used = (one.decision.input.sequence, one.decision.input.source_time_ns)
        if used != self._input:
            self._memory, self._input = self._following, used
        stacks = _stack([one.decision], self._policy.contract)
        q_values, winners, self._following = self._policy.decide(stacks, self._memory)
        return q_values[0], int(winners[0])

    def _start(self) -> Memories:
        start = start_of(self._policy.contract, 1)
        assert start is not None  # it is only asked in order because it has a memory
        return start


def _stack(decisions: Sequence[Decision], contract: PolicyContract) -> RetinaBatch:
    flat = np.frombuffer(b"".join(d.retina for d in decisions), np.uint8)
    return flat.reshape(len(decisions), *contract.retina.stack_shape)


def _recorded_memories(batch: Sequence[Asked], contract: PolicyContract) -> Memories:
    start, size = contract.state.start_value, contract.state.size
    rows = [one.decision.state for one in batch]
    return np.array([row if len(row) == size else start for row in rows], np.float32)


def _value_differences(recorded: QValues, values: QValues) -> Iterator[Difference]:
    """One row, (actions,) each."""
    for i, (old, new) in enumerate(zip(recorded, values, strict=True)):
        if old.tobytes() != new.tobytes():
            yield Difference(f"q_values[{i}]", repr(float(old)), repr(float(new)))
