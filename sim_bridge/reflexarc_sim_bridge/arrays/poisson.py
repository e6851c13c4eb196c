"""How many obstacles a chunk has: Poisson's distribution as a table."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.layers import MAX_SECTIONS, Scatter


def cumulative_counts(layer: Scatter, chunk_m2: float, counts: int) -> npt.NDArray[np.float64]:
    """The probability of at most k obstacles in a chunk, of each section: (8, counts)."""
    factors = layer.sections or (1.0,)
    rows = np.ones((MAX_SECTIONS, counts))  # the last entry stays 1: nothing passes it
    for section, factor in enumerate(factors):
        mean, cumulative = layer.density_per_m2 * factor * chunk_m2, 0.0
        log_mean = math.log(mean) if mean > 0.0 else -math.inf
        for k in range(rows.shape[1] - 1):
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
