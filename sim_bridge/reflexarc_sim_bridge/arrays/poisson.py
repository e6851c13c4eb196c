"""How many obstacles a chunk has: Poisson's distribution as a table."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.kinds.scatter import MAX_SECTIONS


def cumulative_counts(means: Sequence[float], counts: int) -> npt.NDArray[np.float64]:
    """The probability of at most k obstacles in a chunk, of each section: (MAX_SECTIONS, counts).

    Args:
        means: mean count of a chunk of each section.
        counts: how many counts there is room for; the last one always has probability 1.
    """
    rows = np.ones((MAX_SECTIONS, counts))
    for section, mean in enumerate(means):
        cumulative, log_mean = 0.0, math.log(mean) if mean > 0.0 else -math.inf
        for k in range(counts - 1):
            # By its logarithm: exp(−mean) alone is 0 in the densest chunks.
            cumulative += math.exp((k * log_mean if k else 0.0) - mean - math.lgamma(k + 1))
            rows[section, k] = min(cumulative, 1.0)
    return rows


def poisson_quantile(mean: float) -> int:
    """The count that is passed with a probability below 1e-15; at least the mean."""
    probability = cumulative = math.exp(-mean)
    count = 0
    while cumulative < 1.0 - 1e-15 and count < mean + 12 * math.sqrt(mean) + 20:
        count += 1
        probability *= mean / count
        cumulative += probability
    return count + 1
