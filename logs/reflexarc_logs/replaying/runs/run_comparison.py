"""Compares what a policy says of a run of ticks with what was recorded, on arrays."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_logs.replaying.comparison import EqualityRules, are_close
from reflexarc_logs.replaying.runs.held_rows import HeldRows, done_rows
from reflexarc_runtime.arrays import Actions, Memories, QValues
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import LoadedPolicy

BATCH_BYTES = 8 << 20
"""Retinas that go through the policy at once."""


class AskedRun(NamedTuple):
    """A run of ticks at which the policy was asked, and what was being done before each."""

    run: TickRun
    held: HeldRows


class JudgedPart(NamedTuple):
    """What became of some ticks, (ticks,)."""

    special: npt.NDArray[np.bool_]
    """Whether another action won or was done, or may have been: they are judged one by one."""
    identical: npt.NDArray[np.bool_]
    """Whether all is equal under the rules."""

    def alone(self, *, has_first: bool) -> list[int]:
        """The rows to be judged one by one; among them the first that differs, if none has."""
        special = np.flatnonzero(self.special).tolist()
        different = np.flatnonzero(~self.identical)
        if has_first or not len(different) or different[0] in special:
            return special
        return sorted([*special, int(different[0])])

    def is_identical(self, row: int) -> bool:
        """Whether a row is counted among the identical ones."""
        return bool(self.identical[row])


def batch_size(contract: PolicyContract, most: int = BATCH_BYTES) -> int:
    """How many ticks the policy is asked about at once."""
    return max(1, min(most, BATCH_BYTES // (contract.retina.frames * contract.retina.size)))


def decide_part(policy: LoadedPolicy, run: TickRun, part: slice) -> tuple[QValues, Actions]:
    """What a policy says of some ticks of a run, each given the memory that was recorded."""
    contract = policy.contract
    stacks = run.retinas[part].reshape(-1, *contract.retina.stack_shape)
    if not contract.state.size:
        q_values, winners = policy.decide(stacks)
    else:
        q_values, winners, _ = policy.decide(stacks, _memories(run, part, contract))
    return q_values, winners


def _memories(run: TickRun, part: slice, contract: PolicyContract) -> Memories:
    recorded = run.states[part]
    if recorded.shape[1] == contract.state.size:
        return recorded
    return np.tile(np.array(contract.state.start_value, np.float32), (len(recorded), 1))


def judge_part(
    asked: AskedRun,
    part: slice,
    q_values: QValues,
    winners: Actions,
    rules: EqualityRules,
    contract: PolicyContract,
    *,
    has_winner: bool,
) -> JudgedPart:
    """What became of some ticks of a run.

    Args:
        asked: the run.
        part: which of its ticks.
        q_values: what the policy says now, (ticks, actions).
        winners: and which action wins, (ticks,).
        rules: what counts as equal.
        contract: of the policy.
        has_winner: whether ticks say what the policy preferred.
    """
    run, held = asked.run, asked.held
    recorded, actions = run.q_values[part], run.numbers("action")[part]
    identical = (recorded.view(np.uint32) == q_values.view(np.uint32)).all(1)
    if not rules.exact and not identical.all():
        identical |= are_close(recorded, q_values, rules.tolerance).all(1)
    special = ~np.isfinite(q_values).all(1)
    if has_winner:
        before = HeldRows(
            held.actions[part], held.since_slots[part], held.begins and not part.start
        )
        slots = run.numbers("slot")[part]
        special |= winners != run.numbers("winner")[part]
        special |= done_rows(before, q_values, winners, slots, contract) != actions
    else:  # what won was what was done
        special |= winners != actions
    return JudgedPart(special, identical & ~special)
