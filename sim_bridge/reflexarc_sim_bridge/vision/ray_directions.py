"""Directions of an eye's rays in the world's frame."""

import numpy as np

from reflexarc_sim_bridge.arrays.eyes import STEEPEST
from reflexarc_sim_bridge.arrays.layout import EyeParams, Floats32
from reflexarc_sim_bridge.native.decorators import compiled_disjoint
from reflexarc_sim_bridge.obstacles.geometry import reciprocal


@compiled_disjoint
def aim(
    eye: EyeParams,
    cos: np.float32,
    sin: np.float32,
    ahead: Floats32,
    left: Floats32,
    per_ahead: Floats32,
    per_left: Floats32,
) -> None:
    """Turn the rays of an eye.

    Args:
        eye: gives their directions in its own frame.
        cos: of the agent's heading.
        sin: the same.
        ahead: filled with the x parts of their directions: (subrays,).
        left: filled with the y parts.
        per_ahead: filled with 1 / ahead, finite.
        per_left: filled with 1 / left, finite.
    """
    for k in range(eye.ahead.size):
        ahead[k] = eye.ahead[k] * cos - eye.left[k] * sin
        left[k] = eye.ahead[k] * sin + eye.left[k] * cos
        per_ahead[k] = reciprocal(ahead[k], STEEPEST)
        per_left[k] = reciprocal(left[k], STEEPEST)
