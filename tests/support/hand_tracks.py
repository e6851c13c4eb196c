"""Tracks made by hand: straight ahead along x among nothing, but for what a test says."""

from dataclasses import replace
from typing import Any

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.figures import figures_of
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.metrics.track import Circumstances, Floats, Track
from reflexarc_sim_bridge.evaluation.protocol.results import row_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

SIDEWAYS = Circumstances(
    dt_s=0.1,
    forward_mps=1.0,
    lateral_mps=1.0,
    angular_radps=0.0,
    radius_m=0.0,
    obstacle_radius_m=0.5,
    latency_s=0.0,
    range_m=5.0,
    fov_rad=np.pi,
    width_m=20.0,
    free_path_m=2.0,
    lateral=np.array([0, 1, -1], np.int8),
)
"""R = 0.5 m, R/w = 0.5 s: what is met within 1 s is a threat."""
TURNING = replace(SIDEWAYS, lateral_mps=0.0, angular_radps=1.0)


def track_of(
    steps: int, agents: int = 1, circumstances: Circumstances = SIDEWAYS, **given: Any
) -> Track:
    """A track of one world.

    Args:
        steps: how many.
        agents: how many.
        circumstances: in which.
        given: arrays of a track in place of straight on: each is broadcast from (steps, 1).
    """
    shape = steps, agents
    step_m = circumstances.dt_s * circumstances.forward_mps
    values: dict[str, Any] = {
        "x_m": step_m * np.arange(steps, dtype=np.float64)[:, np.newaxis],
        "y_m": 10.0,
        "heading_rad": 0.0,
        "progress_m": step_m,
        "actions": 0,
        "met": False,
        "clearance_m": 5.0,
        "ahead_s": np.inf,
    }
    kinds = {"actions": np.int8, "met": np.bool_, "clearance_m": np.float32, "ahead_s": np.float32}
    for name, value in given.items():
        array = np.asarray(value)
        values[name] = array[:, np.newaxis] if array.ndim == 1 else array
    arrays = {
        name: np.broadcast_to(value, shape).astype(kinds.get(name, np.float64))
        for name, value in values.items()
    }
    return Track(circumstances, agents, **arrays)


def path_of(x_m: Floats, y_m: Floats, **given: Any) -> Track:
    """A track of a body that turns, along places (steps,): its heading is that of its path."""
    heading_rad = np.arctan2(np.gradient(y_m), np.gradient(x_m))
    progress_m = np.diff(x_m, append=x_m[-1])
    fields = {"x_m": x_m, "y_m": y_m, "heading_rad": heading_rad, "progress_m": progress_m}
    return track_of(len(x_m), 1, TURNING, **{**fields, **given})


def marks(steps: int, *at: int) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """True at some steps: (steps,)."""
    return np.isin(np.arange(steps), at)


def figures(*tracks: Track) -> dict[str, float]:
    """All figures of tracks taken together."""
    return figures_of(row_of("x", Setting.FIELD, "f", "t", sums_of(track)) for track in tracks)
