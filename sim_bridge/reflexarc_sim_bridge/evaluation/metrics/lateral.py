"""Metric 9, where across the world an agent is, and whether it prefers a side.

- Edge index E: see `edge_index.py`.
- Divergence from uniform: Σ p log₂(p n) over n bins across, in bits: 0 for who is everywhere alike.
- Mirror tests: the Jensen–Shannon divergence (0 to 1 bit) between the distribution over places, or
  over right, stay and left, and its mirror image. A field is the same in a mirror; an agent that is
  not has a bias.

Only where there are sides or a seam: an unbounded world has no width.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.switches import entropy_bits
from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track

BINS = 20


def edge_time_s(track: Track) -> Floats:
    """Time within 2R of a side, divided by 4R/W: (agents,)."""
    width_m, band_m = track.circumstances.width_m, 2.0 * track.circumstances.obstacle_radius_m
    near = (track.y_m < band_m) | (track.y_m > width_m - band_m)
    share = 2.0 * band_m / width_m
    time_s: Floats = near.sum(axis=0) * (track.circumstances.dt_s * _has_edges(track) / share)
    return time_s


def sided_time_s(track: Track) -> Floats:
    """Time where there are sides that are more than 4R apart: (agents,)."""
    return np.full(track.agents, track.steps * track.circumstances.dt_s * _has_edges(track))


def place_steps(track: Track) -> Floats:
    """Steps by lateral bin, from the right: (agents, BINS)."""
    if not track.circumstances.has_sides:
        return np.zeros((track.agents, BINS))
    bins = np.clip(track.y_m * BINS / track.circumstances.width_m, 0, BINS - 1).astype(np.int64)
    of = np.arange(track.agents) * BINS + bins
    counts = np.bincount(of.ravel(), minlength=track.agents * BINS)
    return counts.reshape(track.agents, BINS).astype(np.float64)


def side_steps(track: Track) -> Floats:
    """Steps that went right, stayed, went left: (agents, 3)."""
    lateral = track.lateral
    counts = [(lateral == side).sum(axis=0) for side in (-1, 0, 1)]
    return np.stack(counts, axis=1).astype(np.float64)


def divergence_bits(counts: Floats) -> float:
    """From uniform: (bins,); NaN where nothing was counted."""
    return float(np.log2(len(counts))) - entropy_bits(counts)


def mirror_bits(counts: Floats) -> float:
    """From its mirror image: (bins,); NaN where nothing was counted.

    Both have the same entropy, so that it is the entropy of their mean less that.
    """
    return entropy_bits((counts + counts[::-1]) / 2.0) - entropy_bits(counts)


def _has_edges(track: Track) -> bool:
    circumstances = track.circumstances
    return circumstances.has_sides and 4.0 * circumstances.obstacle_radius_m < circumstances.width_m
