"""Which action is done: the policy's winner, unless the one before is still held.

The same rule for the controller, the simulator and replay. Held actions are an old remedy against
a reflex that flickers between left and right: an action is kept for a time, and then until another
one is better by a margin (hysteresis): by a share of what the Q-values differ by, or by a lead in
their own unit. The spread is small where nothing is near, and so is what a share of it keeps out;
a lead in their own unit keeps out most of what differs by noise only (docs/chatter.md).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Hold:
    """The action that is being done, and since which slot."""

    action: int
    since_slot: int


def choose(
    held: Hold | None,
    q_values: Sequence[float],
    winner: int,
    slot: int,
    hold_slots: int,
    margin: float,
    least_lead: float = 0.0,
) -> Hold:
    """What is done at this slot.

    Args:
        held: what was done before; None at the start and after every verdict but OK.
        q_values: of all actions, (actions,).
        winner: index of the largest one.
        slot: number of this slot.
        hold_slots: for how many slots an action is done at least.
        margin: by which share of their spread another action must win, in [0, 1].
        least_lead: by how much it must win, in the unit of the Q-values.
    """
    if held is None:
        return Hold(winner, slot)
    if winner == held.action or slot - held.since_slot < hold_slots:
        return held
    lead = q_values[winner] - q_values[held.action]
    if not outweighs(lead, max(q_values) - min(q_values), margin, least_lead):
        return held
    return Hold(winner, slot)


def slots_of(seconds: float, rate_hz: float) -> int:
    """A time in periods of a loop, rounded up; 0.7 s at 10 Hz are 7 in spite of floats."""
    return max(math.ceil(round(seconds * rate_hz, 6)), int(seconds > 0.0))


def outweighs(lead: Any, spread: Any, margin: float, least_lead: float) -> Any:
    """Whether a lead is that share of the spread, and the least: of numbers, or float64 arrays.

    With no margin every lead is enough, even none: the winner is what the policy says.
    """
    return (lead >= margin * spread) & (lead >= least_lead)
