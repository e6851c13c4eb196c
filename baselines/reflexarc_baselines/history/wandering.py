"""A heading that is drawn by chance and held for a time: wandering, and persistent noise.

It is a heading in the ground's frame: when the body turns by its own action, the heading in the
body's frame turns the other way. A body that only sidesteps never turns.
"""

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.picking import picked
from reflexarc_baselines.randomness import drawn
from reflexarc_runtime.arrays import Actions, Memories, RetinaBatch
from reflexarc_runtime.contract.motion import Action

SIZE = 3
"""Values of the memory: the dice, the heading (rad), and the decisions until the next one."""

_DICE, _HEADING, _WAIT = range(SIZE)


def wandered(
    memory: Memories, retinas: RetinaBatch, widest_rad: float, slots: int
) -> tuple[Floats, Memories]:
    """The headings of this decision, uniform within ± the widest; and the memory with them.

    Args:
        memory: (n, 3), zeros at the start.
        retinas: what is seen, which stirs the dice.
        widest_rad: the greatest heading, to the left or to the right.
        slots: decisions for which a heading is held.
    """
    uniform, dice = drawn(memory[:, _DICE], retinas)
    is_due = memory[:, _WAIT] <= 0.0
    fresh = (2.0 * uniform - 1.0) * np.float32(widest_rad)
    heading = np.where(is_due, fresh, memory[:, _HEADING])
    wait = np.where(is_due, np.float32(slots), memory[:, _WAIT]) - np.float32(1.0)
    dice = np.where(is_due, dice, memory[:, _DICE])
    return heading, np.stack([dice, heading, wait], axis=1)


def turned(
    memory: Memories, winners: Actions, actions: tuple[Action, ...], period_s: float
) -> Memories:
    """The memory after the body has done what was decided.

    If a hold or a guard has it do something else, its heading is wrong by that turn until the next.
    """
    turns_rad = np.array([action.angular_radps * period_s for action in actions], np.float32)
    is_heading = np.arange(SIZE) == _HEADING
    following: Memories = memory - picked(turns_rad, winners)[:, np.newaxis] * is_heading
    return following
