"""Statistics over many runs: the interquartile mean and its bootstrap interval.

As `rliable` has them (Agarwal et al., "Deep Reinforcement Learning at the Edge of the Statistical
Precipice", 2021, section 4). The interquartile mean is the mean of the middle half: from n values,
sorted, ⌊n/4⌋ are left out at either end (`scipy.stats.trim_mean(values, 0.25)`). One bad seed of
four does not move it, and it needs fewer seeds than a median.

The interval is that of the percentile bootstrap: values are drawn with replacement, as many as
there are, and of the interquartile means of many such draws the middle 95 % are taken. Groups, such
as two cells that are compared, are drawn separately (stratified). Draws are seeded: the same values
give the same interval.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

TRIMMED = 0.25
"""Share of the values that is left out at either end."""
COVERAGE = 0.95

_DRAWS = 10_000
_SEED = 20_250_103

Floats = npt.NDArray[np.float64]


class Estimate(NamedTuple):
    """An interquartile mean, or a ratio of two, with its 95 % interval."""

    value: float
    low: float
    high: float


def interquartile_mean(values: Sequence[float] | Floats) -> float:
    """Mean of the middle half.

    Args:
        values: one or more: (n,).
    """
    return float(_middle_means(np.asarray(values, np.float64)[np.newaxis])[0])


def estimate(values: Sequence[float] | Floats) -> Estimate:
    """The interquartile mean of some values: (n,), one or more."""
    value = interquartile_mean(values)
    return Estimate(value, *_interval(_drawn_means(values, np.random.default_rng(_SEED))))


def ratio_estimate(values: Sequence[float] | Floats, base: Sequence[float] | Floats) -> Estimate:
    """Ratio of two interquartile means; the bootstrap draws each group separately.

    Args:
        values: (n,).
        base: of which the interquartile mean is not 0: (m,).
    """
    generator = np.random.default_rng(_SEED)
    drawn, drawn_base = _drawn_means(values, generator), _drawn_means(base, generator)
    value = interquartile_mean(values) / interquartile_mean(base)
    with np.errstate(divide="ignore", invalid="ignore"):
        return Estimate(value, *_interval(drawn / drawn_base))


def _drawn_means(values: Sequence[float] | Floats, generator: np.random.Generator) -> Floats:
    """Interquartile means of bootstrap draws: (draws,)."""
    given = np.asarray(values, np.float64)
    return _middle_means(given[generator.integers(0, len(given), (_DRAWS, len(given)))])


def _middle_means(values: Floats) -> Floats:
    """Interquartile mean of each row of (rows, n): (rows,)."""
    n = values.shape[1]
    cut = int(TRIMMED * n)
    means: Floats = np.sort(values, axis=1)[:, cut : n - cut].mean(axis=1)
    return means


def _interval(draws: Floats) -> tuple[float, float]:
    outside = 50.0 * (1.0 - COVERAGE)
    low, high = np.percentile(draws, (outside, 100.0 - outside))
    return float(low), float(high)
