"""The best next motions of a body that knows what lies within its view, and nothing else.

    S(m, k) = max over motions of      m where it meets something, S(m + 1, k + shift) where not
    P(m, k) = mean over motions of     0                           P(m + 1, k + shift)

S is the last step at which a contact can be put off to, P the chance that a random walk meets
nothing. Places out of view are taken for free: there S is the horizon and P is 1. The motion with
the greatest S is chosen, among equals the one with the greatest P, among those the first.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import compiled_free, compiled_inline

Floats = npt.NDArray[np.float64]


@compiled_free
def plan(
    found: npt.NDArray[np.uint8],
    shifts: npt.NDArray[np.int64],
    row: int,
    ahead_m: float,
    row_m: float,
    range_m: float,
    half_view_rad: float,
    lasts: Floats,
    chances: Floats,
    choices: npt.NDArray[np.int64],
    motions_out: npt.NDArray[np.int64],
) -> None:
    """Find the motions of the next steps.

    Args:
        found: what `lattice.look_along` says of the steps up to the horizon: (steps, rows).
        shifts: how many rows each motion goes to the left: (motions,).
        row: where the body is; the horizon ends before the outermost rows.
        ahead_m: how far each step goes ahead.
        row_m: from row to row.
        range_m: how far the body sees.
        half_view_rad: half of its field of view.
        lasts: scratch: (2, rows).
        chances: scratch: (2, rows).
        choices: scratch, 0 at first: (planned, rows).
        motions_out: filled: the motions of the first steps: (planned,).
    """
    steps, widest = len(found), 0
    for shift in shifts:
        widest = max(widest, abs(shift))
    for m in range(steps - 1, -1, -1):
        forward_m = m * ahead_m
        for k in range(row - m * widest, row + m * widest + 1):
            sideways_m = (k - row) * row_m
            seen = math.hypot(forward_m, sideways_m) < range_m
            seen &= math.fabs(math.atan2(sideways_m, forward_m)) <= half_view_rad
            if m > 0 and not seen:
                lasts[m & 1, k], chances[m & 1, k] = steps, 1.0
                continue
            best = _best(found, shifts, m, k, steps, lasts, chances)
            if m < len(motions_out):
                choices[m, k] = best
    for m in range(len(motions_out)):
        motions_out[m] = choices[m, row]
        row += shifts[motions_out[m]]


@compiled_inline
def _best(
    found: npt.NDArray[np.uint8],
    shifts: npt.NDArray[np.int64],
    m: int,
    k: int,
    steps: int,
    lasts: Floats,
    chances: Floats,
) -> int:
    """The best motion of a place, whose S and P are noted."""
    best, last, chance, total = 0, -1.0, -1.0, 0.0
    for motion in range(len(shifts)):
        one_last, one_chance = float(m), 0.0
        if not (found[m, k] >> motion) & 1:
            one_last, one_chance = float(steps), 1.0
            if m + 1 < steps:
                to = k + shifts[motion]
                one_last, one_chance = lasts[(m + 1) & 1, to], chances[(m + 1) & 1, to]
        total += one_chance
        if one_last > last or (one_last == last and one_chance > chance):
            best, last, chance = motion, one_last, one_chance
    lasts[m & 1, k], chances[m & 1, k] = last, total / len(shifts)
    return best
