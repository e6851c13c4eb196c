"""The score of a cell: where between an agent that never steers and one that knows everything.

    score = clip((C_blind − C) / (C_blind − C_oracle), −1, 1)

C is contacts a metre of progress. 1: as few as is possible; 0: as many as without steering; below 0
it steers into things. Where the two limits hardly differ there is nothing to score, and no score
(NaN), rather than one that is all noise. Who hardly comes ahead avoids nothing: the lowest score.

A body that turns is scored by the distance D from where it began to its first contact, in the same
way between that of a blind one and the farthest that its speed and the time allow.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.evaluation.metrics.sums import Sums
from reflexarc_sim_bridge.evaluation.metrics.track import Floats

LEAST_GAP = 0.1
"""The limits must differ by more than this share of the larger one."""
LEAST_WAY = 0.1
"""Who makes less than this share of the blind agent's progress gets the lowest score."""


def rate_per_m(sums: Sums) -> float:
    """Contacts a metre of progress, all worlds together; infinity where there is no progress."""
    progress_m = float(sums["progress_m"].sum())
    return float(sums["contacts"].sum()) / progress_m if progress_m > 0.0 else float("inf")


def cell_score(own: Sums, blind: Sums, oracle: Sums) -> float:
    """Score of who moves sideways, from sums over the same worlds; NaN: there is none.

    Args:
        own: of the contender.
        blind: of one with its body, rate and speeds that never steers.
        oracle: `oracle_sums` of it.
    """
    if own["progress_m"].sum() / own["time_s"].sum() < LEAST_WAY * _speed_mps(blind):
        return -1.0
    return float(between(rate_per_m(own), rate_per_m(blind), rate_per_m(oracle)))


def between(value: npt.ArrayLike, blind: npt.ArrayLike, best: npt.ArrayLike) -> Floats:
    """Scores of values between two limits, of any shapes that fit; NaN where the limits are one.

    Args:
        value: of the contender.
        blind: of an agent that never steers: score 0.
        best: the best possible: score 1; may be above or below `blind`.
    """
    value, blind, best = np.broadcast_arrays(*map(_floats, (value, blind, best)))
    gap = blind - best
    is_scored = np.abs(gap) > LEAST_GAP * np.maximum(np.abs(blind), np.abs(best))
    scores = (blind - value) / np.where(is_scored, gap, 1.0)
    return np.where(is_scored, np.clip(scores, -1.0, 1.0), np.nan)


def _speed_mps(sums: Sums) -> float:
    return float(sums["progress_m"].sum() / sums["time_s"].sum())


def _floats(values: npt.ArrayLike) -> Floats:
    return np.asarray(values, np.float64)
