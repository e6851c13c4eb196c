"""Metric 4, clearance: how close an agent comes to obstacles, in units of R.

A histogram over time (which can be added) gives the 5th percentile, and how much of the time it was
below 0.5 R. The least clearance is that of each agent, 0 for one that met anything; the mean over
agents is the figure.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track

BIN, BINS = 0.05, 60
"""Width of a bin in R, and how many; the last one holds all that is farther."""
CLOSE = 0.5
"""Below so many R it is close."""


def clearance_steps(track: Track) -> Floats:
    """Steps by bin of the clearance: (agents, BINS)."""
    bins = np.minimum(_in_radii(track) / BIN, BINS - 1).astype(np.int64)
    of = np.arange(track.agents) * BINS + bins
    counts = np.bincount(of.ravel(), minlength=track.agents * BINS)
    return counts.reshape(track.agents, BINS).astype(np.float64)


def close_time_s(track: Track) -> Floats:
    """Time with a clearance below 0.5 R: (agents,)."""
    time_s: Floats = (_in_radii(track) < CLOSE).sum(axis=0) * track.circumstances.dt_s
    return time_s


def least_clearance(track: Track) -> Floats:
    """Least clearance, in R: (agents,)."""
    least: Floats = np.where(track.met.any(axis=0), 0.0, _in_radii(track).min(axis=0))
    return least


def percentile(counts: Floats, share: float) -> float:
    """The clearance below which a share of the time lies, in R; NaN without any time.

    Args:
        counts: steps by bin: (BINS,).
        share: in [0, 1].
    """
    total = counts.sum()
    if total == 0.0:
        return float("nan")
    upto = np.concatenate([[0.0], np.cumsum(counts)]) / total
    k = int(np.searchsorted(upto, share, side="right")) - 1
    k = min(k, len(counts) - 1)
    inside = (share - upto[k]) / (upto[k + 1] - upto[k]) if upto[k + 1] > upto[k] else 0.0
    return float(BIN * (k + inside))


def _in_radii(track: Track) -> Floats:
    return track.clearance_m.astype(np.float64) / track.circumstances.obstacle_radius_m
