"""For bodies that turn: the greatest distance from the start before the first contact or the end.

A body that turns has no way to go, so contacts on its path breed circling, and net displacement in
windows without a contact is cheated by it too. Its greatest distance from where it began is not:
a circle ends where it began. Not its last distance, which the time of the contact decides. The mean
over agents is restricted, by the time for which they are watched. Across a seam it goes on.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track


def farthest_m(track: Track) -> Floats:
    """(agents,)."""
    none = np.zeros((1, track.agents))
    left_m = np.vstack([none, np.cumsum(track.left_m, axis=0)])
    away_m = np.hypot(track.x_m - track.x_m[0], left_m)
    met_before = np.vstack([none > 0.0, np.cumsum(track.met[:-1], axis=0) > 0])
    farthest: Floats = np.where(met_before, 0.0, away_m).max(axis=0)
    return farthest
