"""Replay at level `policy`: each tick's retinas through the policy, in batches.

Ticks at which the policy was not asked have no Q-values and are not compared.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.comparison import EqualityRules, LevelResult, Tally, find_flip
from reflexarc_logs.replaying.message_fields import Difference
from reflexarc_runtime.arrays import QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import LoadedPolicy

BATCH_BYTES = 8 << 20
"""Retinas that go through the policy at once."""


def replay_policy(log: Log, policy: LoadedPolicy, rules: EqualityRules) -> LevelResult:
    """Ask the policy again about every tick at which it was asked.

    Raises:
        LogError: the log cannot be read, or its retinas are not those of this policy.
    """
    tally = Tally("policy", rules)
    for batch in _batches(_asked(log, policy.contract, tally), policy.contract):
        _compare(batch, policy, tally)
    return tally.result()


def _asked(log: Log, contract: PolicyContract, tally: Tally) -> Iterator[Decision]:
    """Count every tick; yield those that have Q-values."""
    expected = contract.retina.frames * contract.retina.size, len(contract.actions)
    for tick in log.ticks():
        tally.ticks += 1
        decision = tick.decision
        if not decision.q_values:
            continue
        got = len(decision.retina), len(decision.q_values)
        if got != expected:
            raise LogError(
                f"{log.path}: tick {decision.index}: the policy takes and gives {expected} "
                f"(retina bytes, Q-values), the log holds {got}; give a policy that fits"
            )
        yield decision


def _batches(
    decisions: Iterator[Decision], contract: PolicyContract
) -> Iterator[Sequence[Decision]]:
    size = max(1, BATCH_BYTES // (contract.retina.frames * contract.retina.size))
    batch: list[Decision] = []
    for decision in decisions:
        batch.append(decision)
        if len(batch) >= size:
            yield batch
            batch = []
    if batch:
        yield batch


def _compare(batch: Sequence[Decision], policy: LoadedPolicy, tally: Tally) -> None:
    replayed, winners = policy.decide(_stack(batch, policy.contract))
    recorded: QValues = np.array([d.q_values for d in batch], np.float32)
    same = (recorded.view(np.uint32) == replayed.view(np.uint32)).all(axis=1)
    for row, decision in enumerate(batch):
        differences: list[Difference] = []
        if not same[row]:
            differences += _value_differences(recorded[row], replayed[row])
        flip, winner = None, int(winners[row])
        if decision.verdict == Verdict.OK.value and decision.action != winner:
            flip = find_flip(decision.index, decision.q_values, decision.action, winner)
            differences.append(Difference("action", str(decision.action), str(winner)))
        tally.add(decision.index, 2, differences, flip)


def _stack(batch: Sequence[Decision], contract: PolicyContract) -> RetinaBatch:
    flat = np.frombuffer(b"".join(d.retina for d in batch), np.uint8)
    return flat.reshape(len(batch), *contract.retina.stack_shape)


def _value_differences(recorded: QValues, replayed: QValues) -> Iterator[Difference]:
    """One row, (actions,) each."""
    for i, (old, new) in enumerate(zip(recorded, replayed, strict=True)):
        if old.tobytes() != new.tobytes():
            yield Difference(f"q_values[{i}]", repr(float(old)), repr(float(new)))
