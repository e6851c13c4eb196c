"""Exact Poisson intervals of a count, and when they may be used (Garwood 1936).

Of a count k the 95 % interval is [a, b] with P(X ≥ k; a) = P(X ≤ k; b) = 2.5 %. For k = 0 it is
[0, 3.69]. It holds where contacts come independently of each other, which shows in the dispersion,
the variance of the counts of equal worlds over their mean: 1 for Poisson's, more where contacts
come in groups, less where they keep a distance.
"""

import math
from collections.abc import Callable

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats

NEAR_ONE = 0.25
"""A dispersion within this of 1 counts as Poisson's. At 1.25 the interval is 11 % too narrow."""

_TAIL = 0.025
_HALVINGS = 200


def dispersion(counts: Floats) -> float | None:
    """Variance over mean of the counts of equal worlds, (worlds,); None where nothing happened."""
    mean = float(counts.mean())
    return float(counts.var(ddof=1)) / mean if mean > 0.0 and len(counts) > 1 else None


def may_be_poisson(counts: Floats) -> bool:
    """Whether their dispersion is near 1, or nothing happened at all: (worlds,)."""
    spread = dispersion(counts)
    if spread is None:
        return not counts.any()
    return abs(spread - 1.0) <= NEAR_ONE


def poisson_interval(count: int) -> tuple[float, float]:
    """The exact 95 % interval of the mean of which one count was seen."""
    top = count + 20.0 * math.sqrt(count + 1.0) + 20.0
    high = _falling_root(lambda mean: _at_most(count, mean) - _TAIL, top)
    if count == 0:
        return 0.0, high
    low = _falling_root(lambda mean: _at_most(count - 1, mean) - (1.0 - _TAIL), top)
    return low, high


def _at_most(count: int, mean: float) -> float:
    """P(X ≤ count) of a Poisson variable."""
    k = np.arange(count + 1)
    logarithms = k * math.log(mean) - mean - _log_factorials(count)
    return float(np.exp(logarithms).sum())


def _log_factorials(count: int) -> Floats:
    return np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, count + 1)))])


def _falling_root(falling: Callable[[float], float], top: float) -> float:
    low, high = 0.0, top
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if falling(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)
