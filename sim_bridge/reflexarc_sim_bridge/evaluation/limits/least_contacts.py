"""The least contacts that can be expected from every place of a lattice: dynamic programming.

    V(n, k) = min over motions a of    [n is counted] + M(n + 1)    where a meets something
                                       V(n + 1, k + shift of a)     where it does not

M(n) is the mean of V(n, ·) over the places where one can stand: whoever meets something goes on at
such a place, all being equally likely. Where a whole line is blocked, that of the next one. Behind
the last step V is 0.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import compiled_free, compiled_inline, compiled_inner
from reflexarc_sim_bridge.simulation.lattice import COVERED

Values = npt.NDArray[np.float64]


@compiled_free
def go_back(
    found: npt.NDArray[np.uint8],
    shifts: npt.NDArray[np.int64],
    wraps: bool,
    window: int,
    uncounted: int,
    values: Values,
    anew: Values,
    scratch: Values,
) -> None:
    """From the values behind some steps to those before them.

    Args:
        found: what `lattice.look_along` says: (steps, rows).
        shifts: how many rows each motion goes to the left: (motions,).
        wraps: whether the last row lies beside the first; else motions end at the outermost rows.
        window: so many rows to either side are where one goes on after a contact; 0: all.
        uncounted: contacts in the first so many of these steps cost nothing.
        values: V behind the steps, then before them; infinity where one cannot stand: (rows,).
        anew: M behind the steps, then before them: (rows,).
        scratch: (2, rows + 1).
    """
    ahead, rows = scratch[0], len(values)
    for n in range(len(found) - 1, -1, -1):
        cost = 1.0 if n >= uncounted else 0.0
        for row in range(rows):
            ahead[row] = values[row]
        for row in range(rows):
            bits = found[n, row]
            values[row] = math.inf
            if not bits & COVERED:
                met = cost + anew[row]
                values[row] = _least(bits, row, shifts, wraps, ahead, met, rows)
        _average(values, window, anew, scratch)


@compiled_inline
def _least(
    bits: int,
    row: int,
    shifts: npt.NDArray[np.int64],
    wraps: bool,
    ahead: Values,
    met: float,
    rows: int,
) -> float:
    """V of a place; `met` is what a contact costs, `ahead` is V one step on."""
    least = math.inf
    for k in range(len(shifts)):
        value = math.inf
        if not (bits >> k) & 1:
            to = row + shifts[k]
            if wraps:
                to = to - rows if to >= rows else to + rows if to < 0 else to
            value = ahead[min(max(to, 0), rows - 1)]
        # A step that ends within a micrometre of an obstacle ends, as it were, in it.
        least = min(least, met if math.isinf(value) else value)
    return least


@compiled_inner
def _average(values: Values, window: int, anew: Values, scratch: Values) -> None:
    """M from V; where nobody can stand it stays what it is one step on."""
    rows, sums, counts = len(values), scratch[0], scratch[1]
    sums[0] = counts[0] = 0.0
    for row in range(rows):
        free = not math.isinf(values[row])
        sums[row + 1] = sums[row] + (values[row] if free else 0.0)
        counts[row + 1] = counts[row] + free
    for row in range(rows):
        first = max(row - window, 0) if window else 0
        end = min(row + window + 1, rows) if window else rows
        count = counts[end] - counts[first]
        if count > 0.0:
            anew[row] = (sums[end] - sums[first]) / count
