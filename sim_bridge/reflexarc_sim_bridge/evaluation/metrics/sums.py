"""What a track adds up to, world by world: every figure is a ratio of such sums.

Sums of different worlds, agents and stretches can be added, so that it does not matter in how many
pieces a cell was driven.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.greatest_distance import greatest_distance_m
from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track

Sums = dict[str, Floats]
"""By the name of the sum: one value a world: (worlds,)."""


def _contacts(track: Track) -> Floats:
    contacts: Floats = track.met.sum(axis=0, dtype=np.float64)
    return contacts


def _progress_m(track: Track) -> Floats:
    progress_m: Floats = track.progress_m.sum(axis=0)
    return progress_m


def _time_s(track: Track) -> Floats:
    return np.full(track.met.shape[1], track.steps * track.circumstances.dt_s)


def _agents(track: Track) -> Floats:
    return np.ones(track.met.shape[1])


def _straight_m(track: Track) -> Floats:
    """How far it would get straight ahead, were there nothing in its way."""
    return _time_s(track) * track.circumstances.forward_mps


PER_AGENT: Mapping[str, Callable[[Track], Floats]] = MappingProxyType(
    {
        "agents": _agents,
        "contacts": _contacts,
        "progress_m": _progress_m,
        "time_s": _time_s,
        "greatest_m": greatest_distance_m,
        "straight_m": _straight_m,
    }
)
"""Each from a track to (agents,)."""


def sums_of(track: Track) -> Sums:
    """All sums of a track."""
    return {name: track.over_worlds(each(track)) for name, each in PER_AGENT.items()}
