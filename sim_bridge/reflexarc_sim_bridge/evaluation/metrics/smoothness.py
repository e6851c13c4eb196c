"""Metric 8, smoothness. A second axis, never part of a score: who does nothing is smoothest.

For who moves sideways, Σ|Δy| / Σ|Δx|: way aside for each metre ahead. For a body that turns, the
mean |curvature| Σ|Δθ| / Σ|Δs| in rad/m, and the log dimensionless jerk

    −ln( t₀⁴ · mean |d³x/dt³|² / v² ),   t₀ = 1 s

of its place x, v its forward speed: Hogan and Sternad's ("Sensitivity of smoothness measures to
movement duration, amplitude, and arrests", 2009) for movements that last t₀. On a circle at the
rate ω it is −4 ln(ω t₀). The jerk is the third difference of places, so that it can be added.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.collisions import steps_m
from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track


def aside_m(track: Track) -> Floats:
    """Σ|Δy| of who moves sideways: (agents,)."""
    return _where(track, not track.circumstances.turns, np.abs(track.left_m))


def ahead_m(track: Track) -> Floats:
    """Σ|Δx| of the same steps: (agents,)."""
    return _where(track, not track.circumstances.turns, np.abs(track.progress_m[:-1]))


def turned_rad(track: Track) -> Floats:
    """Σ|Δθ| of a body that turns: (agents,)."""
    changes = np.diff(track.heading_rad, axis=0)
    changes -= 2.0 * np.pi * np.round(changes / (2.0 * np.pi))
    return _where(track, track.circumstances.turns, np.abs(changes))


def turned_way_m(track: Track) -> Floats:
    """Σ|Δs| of the same steps: (agents,)."""
    return _where(track, track.circumstances.turns, steps_m(track)[:-1])


def jerk(track: Track) -> Floats:
    """∫|jerk|² dt / v² of a body that turns, in s⁻³: (agents,)."""
    circumstances = track.circumstances
    if not circumstances.turns or track.steps < 4 or circumstances.forward_mps <= 0.0:
        return np.zeros(track.agents)
    steps = np.diff(track.x_m, axis=0), track.left_m
    squares = sum(np.diff(each, n=2, axis=0) ** 2 for each in steps)
    scale = circumstances.dt_s**5 * circumstances.forward_mps**2
    found: Floats = np.where(_goes_on_thrice(track), squares, 0.0).sum(axis=0) / scale
    return found


def jerk_time_s(track: Track) -> Floats:
    """Time over which that was taken: (agents,)."""
    if not track.circumstances.turns or track.steps < 4:
        return np.zeros(track.agents)
    time_s: Floats = _goes_on_thrice(track).sum(axis=0) * track.circumstances.dt_s
    return time_s


def _goes_on_thrice(track: Track) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    goes_on = track.goes_on
    return goes_on[2:] & goes_on[1:-1] & goes_on[:-2]


def _where(track: Track, counts: bool, values: Floats) -> Floats:
    """Sum over the steps that lead to the next; 0 where the figure is not of this body."""
    sums: Floats = np.where(track.goes_on & counts, values, 0.0).sum(axis=0)
    return sums
