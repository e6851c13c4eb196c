"""Metrics 3, 5 and 6: what an agent does about obstacles that it is about to meet.

A threat is a maximal stretch of time in which an agent that went straight on would meet something
within T_h = 2(R/w + τ): twice as long as it takes to get out of the way. A threat that the end of
the track cuts off counts for nothing.

- Threat avoidance 1 − collisions / threats. A collision without a threat before, such as a sidestep
  into what was beside, counts as a threat that was not avoided: so it lies in [0, 1]. Hiding in
  empty places earns nothing: there are no threats there.
- Exposure: share of the time with less than T_h to the collision ahead, and with less than 1 s.
- Least time to collision in a threat, 0 where it ends in one; the mean over threats.
- Reaction distance: how far the obstacle ahead was when the agent first left "stay" in a threat;
  also as a multiple of v(τ + R/w), below which nobody can get out of its way. Only threats in which
  it does leave "stay" count; that share is a figure of its own.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.collisions import onsets
from reflexarc_sim_bridge.evaluation.metrics.stretches import (
    Stretches,
    least_in,
    stretches_of,
    summed,
)
from reflexarc_sim_bridge.evaluation.metrics.track import Bools, Floats, Track

SOON_S = 1.0


def threats_of(track: Track) -> Stretches:
    """All threats, those that are cut off too."""
    return stretches_of(track, _is_threat(track))


def threats(track: Track) -> Floats:
    """How many there were: (agents,)."""
    return summed(track, _whole(threats_of(track)).agent)


def met_threats(track: Track) -> Floats:
    """How many ended in a collision: (agents,)."""
    whole = _whole(threats_of(track))
    return summed(track, whole.agent, onsets(track)[whole.last, whole.agent])


def surprises(track: Track) -> Floats:
    """Collisions without a threat before: (agents,)."""
    alone: Floats = (onsets(track) & ~_is_threat(track)).sum(axis=0).astype(np.float64)
    return alone


def threat_time_s(track: Track) -> Floats:
    """Time with less than T_h to the collision ahead: (agents,)."""
    return _time_s(track, _is_threat(track))


def soon_time_s(track: Track) -> Floats:
    """Time with less than 1 s to the collision ahead: (agents,)."""
    return _time_s(track, track.ahead_s < SOON_S)


def least_ahead_s(track: Track) -> Floats:
    """Sum over threats of the least time to collision: (agents,)."""
    whole = _whole(threats_of(track))
    least_s = np.where(whole.ends_met, 0.0, least_in(whole, track.ahead_s))
    return summed(track, whole.agent, least_s)


def reactions(track: Track) -> Floats:
    """In how many threats it left "stay": (agents,)."""
    agent, _ = _reactions(track)
    return summed(track, agent)


def reaction_m(track: Track) -> Floats:
    """Sum over these of the distance to the obstacle ahead: (agents,)."""
    agent, ahead_s = _reactions(track)
    return summed(track, agent, ahead_s * track.circumstances.forward_mps)


def reaction_limits(track: Track) -> Floats:
    """The same as multiples of v(τ + R/w): (agents,)."""
    agent, ahead_s = _reactions(track)
    return summed(track, agent, ahead_s / (0.5 * track.circumstances.threat_s))


def _reactions(track: Track) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], Floats]:
    """Whose it is, and the time to the collision then, for each threat with a reaction."""
    whole = _whole(threats_of(track))
    numbers = np.arange(track.steps, dtype=np.float64)[:, np.newaxis]
    leaves = np.where(track.lateral != 0, numbers, float(track.steps))
    at = least_in(whole, leaves).astype(np.int64)
    found = at < track.steps
    return whole.agent[found], track.ahead_s[at[found], whole.agent[found]].astype(np.float64)


def _is_threat(track: Track) -> Bools:
    return track.ahead_s < track.circumstances.threat_s


def _whole(found: Stretches) -> Stretches:
    agent, first, last, met, is_cut = found
    whole = ~is_cut
    return Stretches(agent[whole], first[whole], last[whole], met[whole], is_cut[whole])


def _time_s(track: Track, holds: Bools) -> Floats:
    time_s: Floats = holds.sum(axis=0) * track.circumstances.dt_s
    return time_s
