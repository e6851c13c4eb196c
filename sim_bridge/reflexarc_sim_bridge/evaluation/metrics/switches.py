"""Metric 7, chatter: how often an agent changes what it does, and how varied that is.

A switch is a step that does something else than the one before, with no contact between; a reversal
one from left to right or back. A hold is a stretch of one action between two switches; the share of
those that last a single step shows decisions that the next one takes back. The entropy of the
actions, −Σ p log₂ p in bits, is 0 for who always does the same, log₂ n for who does all of n alike.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Bools, Floats, Track


def switches(track: Track) -> Floats:
    """(agents,)."""
    return _count(_switched(track))


def reversals(track: Track) -> Floats:
    """Switches from left to right or back: (agents,)."""
    return _count(track.goes_on & (track.lateral[1:] * track.lateral[:-1] < 0))


def holds(track: Track) -> Floats:
    """Stretches of one action between two switches: (agents,)."""
    whole, _ = _holds(track)
    return np.bincount(whole, minlength=track.agents).astype(np.float64)


def short_holds(track: Track) -> Floats:
    """Those that last one step: (agents,)."""
    whole, lasted = _holds(track)
    return np.bincount(whole[lasted == 1], minlength=track.agents).astype(np.float64)


def action_steps(track: Track) -> Floats:
    """Steps by action: (agents, actions)."""
    kinds = range(len(track.circumstances.lateral))
    return np.stack([_count(track.actions == kind) for kind in kinds], axis=1)


def entropy_bits(counts: Floats) -> float:
    """Of a distribution, by counts: (kinds,); NaN where nothing was counted."""
    total = counts.sum()
    if total == 0.0:
        return float("nan")
    p = counts[counts > 0.0] / total
    return float(abs((p * np.log2(p)).sum()))


def _switched(track: Track) -> Bools:
    switched: Bools = track.goes_on & (track.actions[1:] != track.actions[:-1])
    return switched


def _holds(track: Track) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], Floats]:
    """Whose each whole hold is, and how many steps it lasts."""
    switched = _switched(track)
    agent, step = np.nonzero((switched | ~track.goes_on).T)
    by_switch = switched[step, agent]
    whole = (agent[1:] == agent[:-1]) & by_switch[1:] & by_switch[:-1]
    return agent[1:][whole], np.diff(step)[whole].astype(np.float64)


def _count(marks: Bools) -> Floats:
    count: Floats = marks.sum(axis=0).astype(np.float64)
    return count
