"""How far bodies that turn get: the greatest distance from the start before the first contact.

Over a fixed time T this is a restricted mean. A body that circles gets nowhere, whatever it does
not touch; contacts per metre of its path would praise it.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track


def greatest_distance_m(track: Track) -> Floats:
    """Of each agent: (agents,)."""
    across_m = np.unwrap(track.y_m, period=track.circumstances.width_m, axis=0)
    from_start_m = np.hypot(track.x_m - track.x_m[0], across_m - across_m[0])
    touched_before = np.cumsum(track.met, axis=0) - track.met > 0
    greatest_m: Floats = np.where(touched_before, 0.0, from_start_m).max(axis=0)
    return greatest_m
