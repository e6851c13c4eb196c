"""Metric 1, collision rate: how many obstacles are met on the way.

A collision is the beginning of a contact. An agent that is put elsewhere by one begins anew; a
ghost, which goes on through the obstacle, can collide again after 0.5 s with a clearance of 0.1 R
or more. The rate is collisions / way: by metre, and by mean free path ℓ₀ = 1 / 2ρR, of which a body
that never steers has 1 a collision. The way of who moves sideways is its progress along x; of a
body that turns, the length of its path.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Bools, Floats, Track

ARMED_AFTER_S, ARMED_FROM = 0.5, 0.1
"""A ghost is armed after such a time with a clearance of so many R."""


def onsets(track: Track) -> Bools:
    """Which steps ended in a new collision: (steps, agents)."""
    if track.circumstances.respawns:
        return track.met
    clear_m = ARMED_FROM * track.circumstances.obstacle_radius_m
    found, armed = np.zeros_like(track.met), np.ones(track.agents, np.bool_)
    clear_s = np.zeros(track.agents)
    for step in range(track.steps):
        is_clear = track.clearance_m[step] >= clear_m
        clear_s = np.where(is_clear, clear_s + track.circumstances.dt_s, 0.0)
        armed |= clear_s > ARMED_AFTER_S - 1e-9
        found[step] = track.met[step] & armed
        armed &= ~found[step]
    return found


def contacts(track: Track) -> Floats:
    """Collisions: (agents,)."""
    count: Floats = onsets(track).sum(axis=0).astype(np.float64)
    return count


def steps_m(track: Track) -> Floats:
    """Length of the way of each step: (steps, agents)."""
    if not track.circumstances.turns:
        return track.progress_m
    # Where the last step, or one into an obstacle, led to the side, nobody wrote down.
    lengths_m = np.abs(track.progress_m)
    ahead_m = np.where(track.goes_on, np.diff(track.x_m, axis=0), 0.0)
    lengths_m[:-1][track.goes_on] = np.hypot(ahead_m, track.left_m)[track.goes_on]
    return lengths_m


def way_m(track: Track) -> Floats:
    """Length of the way: (agents,)."""
    length_m: Floats = steps_m(track).sum(axis=0)
    return length_m


def free_paths(track: Track) -> Floats:
    """The same in mean free paths: (agents,)."""
    return way_m(track) / track.circumstances.free_path_m


def progress_m(track: Track) -> Floats:
    """Along x: (agents,)."""
    progress: Floats = track.progress_m.sum(axis=0)
    return progress


def time_s(track: Track) -> Floats:
    """How long each was watched: (agents,)."""
    return np.full(track.agents, track.steps * track.circumstances.dt_s)


def agents(track: Track) -> Floats:
    """1 for each agent: (agents,)."""
    return np.ones(track.agents)
