"""Maximal stretches of a track in which something holds, agent by agent.

A contact that puts an agent elsewhere ends a stretch: what follows is another place.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.evaluation.metrics.track import Bools, Floats, Track

Indices = npt.NDArray[np.int64]


class Stretches(NamedTuple):
    """One entry a stretch, those of one agent after each other: (stretches,) each."""

    agent: Indices
    first: Indices
    """First step in it."""
    last: Indices
    """Last step in it."""
    ends_met: Bools
    """Whether its last step ended in a contact."""
    is_cut: Bools
    """Whether the track ended first: nobody knows how it would have gone on."""


def stretches_of(track: Track, holds: Bools) -> Stretches:
    """All stretches in which something holds.

    Args:
        track: whose contacts end stretches.
        holds: whether it holds at each step: (steps, agents).
    """
    joins = holds[1:] & holds[:-1] & track.goes_on
    none = np.zeros((1, holds.shape[1]), np.bool_)
    agent, first = np.nonzero((holds & ~np.vstack([none, joins])).T)
    _, last = np.nonzero((holds & ~np.vstack([joins, none])).T)
    met = track.met[last, agent]
    return Stretches(agent, first, last, met, (last == track.steps - 1) & ~met)


def least_in(stretches: Stretches, values: npt.NDArray[np.floating]) -> Floats:
    """Least of some values (steps, agents) in each stretch: (stretches,)."""
    if len(stretches.agent) == 0:
        return np.zeros(0)
    steps = values.shape[0]
    flat = np.append(values.T.ravel(), np.inf)  # a boundary may lie behind the last
    begins, ends = stretches.agent * steps + stretches.first, stretches.agent * steps
    bounds = np.stack([begins, ends + stretches.last + 1], axis=1).ravel()
    least: Floats = np.minimum.reduceat(flat, bounds)[::2].astype(np.float64)
    return least


def summed(track: Track, agent: Indices, values: npt.ArrayLike = 1.0) -> Floats:
    """Sums of a value for each stretch over the stretches of each agent: (agents,)."""
    weights = np.broadcast_to(np.asarray(values, np.float64), agent.shape)
    return np.bincount(agent, weights, minlength=track.agents).astype(np.float64)
