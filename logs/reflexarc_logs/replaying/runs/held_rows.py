"""What was being done at each tick of a run, and what a policy's answers would make of it."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_logs.columns.tick_columns import Whole
from reflexarc_runtime.arrays import QValues
from reflexarc_runtime.choice import Hold, outweighs
from reflexarc_runtime.contract.contract import PolicyContract


class HeldRows(NamedTuple):
    """What was being done before each tick of a run, (ticks,)."""

    actions: Whole
    since_slots: Whole
    begins: bool
    """Whether nothing was before its first tick."""

    def at(self, row: int) -> Hold | None:
        """Before one tick."""
        if self.begins and not row:
            return None
        return Hold(int(self.actions[row]), int(self.since_slots[row]))


def held_rows(held: Hold | None, actions: Whole, slots: Whole) -> tuple[HeldRows, Hold]:
    """Follow the actions of ticks that were all OK; and what is held behind them.

    Args:
        held: what was done before; None: nothing.
        actions: what was done, (ticks,).
        slots: when, (ticks,).
    """
    first = Hold(int(actions[0]), int(slots[0])) if held is None else held
    before = np.concatenate(([first.action], actions[:-1]))
    changes = np.maximum.accumulate(np.where(before != actions, np.arange(len(actions)), -1))
    since = np.where(changes < 0, first.since_slot, slots[changes])
    rows = HeldRows(before, np.concatenate(([first.since_slot], since[:-1])), held is None)
    return rows, Hold(int(actions[-1]), int(since[-1]))


def done_rows(
    held: HeldRows,
    q_values: QValues,
    winners: npt.NDArray[np.int64],
    slots: Whole,
    contract: PolicyContract,
) -> Whole:
    """What is done at each tick, (ticks,): `choice.choose` on arrays.

    Args:
        held: what was done before each of them.
        q_values: (ticks, actions), finite.
        winners: the actions with the largest ones, (ticks,).
        slots: when, (ticks,).
        contract: for how long and by what margin an action is kept.
    """
    if not contract.keeps_actions:
        return winners
    values, each = q_values.astype(np.float64), np.arange(len(winners))
    lead = values[each, winners] - values[each, held.actions]
    spread = values.max(1) - values.min(1)
    stays = (winners == held.actions) | (slots - held.since_slots < contract.hold_slots)
    stays |= ~outweighs(lead, spread, contract.margin, contract.least_lead)
    if held.begins:
        stays[0] = False
    return np.where(stays, held.actions, winners)
