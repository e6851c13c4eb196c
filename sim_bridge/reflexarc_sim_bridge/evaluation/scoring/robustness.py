"""Metric 12, robustness area: how much of its score a policy keeps in worlds that are made worse.

Mean score over a grid of perturbations, divided by the score without any: 1 for who does not mind,
0 for who does no better than an agent that never steers. The grid is the family `robustness` of a
suite; its cell `none` is the world as it is.
"""

import math
from collections.abc import Callable, Iterable

from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow

FAMILY, NOMINAL = "robustness", "none"


def robustness_area(rows: Iterable[ResultRow], score_of: Callable[[ResultRow], float]) -> float:
    """The area of one contender in one setting.

    Args:
        rows: its rows; those of other families do not count.
        score_of: the score of a row, at most 1.

    Returns:
        NaN without the world as it is or any made worse, or where the score as it is is not above
        0: who does no better than blind there has nothing to keep.
    """
    scores = {row.tier: score_of(row) for row in rows if row.family == FAMILY}
    nominal = scores.pop(NOMINAL, math.nan)
    if not scores or not nominal > 0.0:
        return math.nan
    return math.fsum(scores.values()) / len(scores) / nominal
