"""Metric 2, how far and how long an agent goes on without a collision.

Each stretch from a collision, or from the beginning, to the next collision is one life. A life that
the end of the track cuts off is censored: it counts for as long as it was seen. With n lives that
reach a bin, d that end in it and c that are cut off in it, a life that reaches the bin survives it
with 1 − d / (n − c/2) (the life-table form of Kaplan and Meier's estimator, "Nonparametric
Estimation from Incomplete Observations", 1958, section 3). The restricted mean is the area under
the curve up to the last bin.

Ways are in mean free paths ℓ₀, times in ℓ₀/v: a body that never steers has a restricted mean of
nearly 1 by both. Counts of lives by bin can be added over agents and worlds.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.collisions import onsets, steps_m
from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track

BIN, BINS = 0.25, 40
"""Length of a bin in mean free paths, and how many: up to 10."""


def way_lives(track: Track) -> Floats:
    """Lives by bin of the way: see `_lives`."""
    return _lives(track, steps_m(track) / track.circumstances.free_path_m)


def time_lives(track: Track) -> Floats:
    """Lives by bin of the time: see `_lives`."""
    circumstances = track.circumstances
    step = circumstances.dt_s * circumstances.forward_mps / circumstances.free_path_m
    return _lives(track, np.full(track.met.shape, step))


def survival_curve(lives: Floats) -> Floats:
    """Share that goes on at the borders of the bins, 1 at the first: (BINS + 1,).

    Args:
        lives: reach, end: (2, BINS + 1).

    Returns:
        NaN behind the last bin that any life reaches.
    """
    reach, end = lives[0, :-1], lives[1, :-1]
    cut = reach - end - lives[0, 1:]
    at_risk = reach - 0.5 * cut
    with np.errstate(divide="ignore", invalid="ignore"):
        survives = 1.0 - end / at_risk
    curve: Floats = np.append(1.0, np.cumprod(survives))
    return curve if reach[0] else np.full_like(curve, np.nan)


def restricted_mean(lives: Floats) -> float:
    """Area under the curve, in mean free paths: at most `BIN · BINS`; NaN where nobody lived.

    Where no life goes on so far, the curve is taken to stay as it was.
    """
    curve = survival_curve(lives)
    known = curve[np.maximum.accumulate(np.where(np.isnan(curve), 0, np.arange(len(curve))))]
    return float(BIN * (known[1:] + known[:-1]).sum() / 2.0)


def _lives(track: Track, lengths: Floats) -> Floats:
    """How many lives reach each bin, and how many end in it: (agents, 2, BINS + 1).

    The last bin holds all that is longer.

    Args:
        track: whose collisions end lives.
        lengths: of each step: (steps, agents).
    """
    ends = onsets(track)
    gone = np.cumsum(lengths, axis=0)
    agent, step = np.nonzero(ends.T)
    is_first = np.diff(agent, prepend=-1) != 0
    until = gone[step, agent]
    ended = until - np.where(is_first, 0.0, np.concatenate([[0.0], until[:-1]]))
    last = np.zeros(track.agents)
    np.maximum.at(last, agent, until)
    cut = gone[-1] - last
    found = np.zeros((track.agents, 2, BINS + 1))
    np.add.at(found[:, 1], (agent, _bin(ended)), 1.0)
    ones = found[:, 1].copy()
    seen = cut > 0.0
    np.add.at(ones, (np.flatnonzero(seen), _bin(cut[seen])), 1.0)
    found[:, 0] = np.cumsum(ones[:, ::-1], axis=1)[:, ::-1]
    return found


def _bin(lengths: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    return np.clip(np.floor(np.maximum(lengths, 0.0) / BIN + 1e-9), 0, BINS).astype(np.int64)
