"""Tracks by hand, for metrics whose value can be worked out on paper."""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.evaluation.metrics.track import Circumstances, Track


def track_of(
    x_m: npt.ArrayLike, y_m: npt.ArrayLike, met: npt.ArrayLike | None = None, **facts: Any
) -> Track:
    """The track of agents at places: (steps, agents); one lane, a width of 20 m, steps of 0.1 s."""
    x, y = np.atleast_2d(np.asarray(x_m, float)), np.atleast_2d(np.asarray(y_m, float))
    touched = np.zeros(x.shape, np.bool_) if met is None else np.asarray(met, np.bool_)
    values = {
        "dt_s": 0.1,
        "forward_mps": 1.0,
        "lateral_mps": 0.0,
        "angular_radps": 1.0,
        "radius_m": 0.0,
        "obstacle_radius_m": 0.45,
        "latency_s": 0.0,
        "range_m": 5.0,
        "fov_rad": np.pi,
        "width_m": 20.0,
        "free_path_m": 2.78,
        "lateral": np.array([0, 1, -1], np.int8),
        **facts,
    }
    return Track(
        circumstances=Circumstances(**values),
        lanes=1,
        x_m=x,
        y_m=y,
        heading_rad=np.zeros(x.shape),
        progress_m=np.zeros(x.shape),
        actions=np.zeros(x.shape, np.int8),
        met=touched,
        clearance_m=np.full(x.shape, np.inf, np.float32),
        ahead_s=np.full(x.shape, np.inf, np.float32),
    )
