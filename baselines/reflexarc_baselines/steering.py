"""From a wish to turn or to step aside, positive to the left, to values of the three actions.

    q(stay) = δ,   q(left) = T,   q(right) = −T

The largest wins, the first of equals. So δ is a dead band: below it, the body stays on its way.
"""

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import Actions, QValues

STAY, LEFT, RIGHT = range(3)
"""Rows of the actions of a contract that a baseline drives by."""


def steer(wish: Floats, dead_band: float = 0.0) -> tuple[QValues, Actions]:
    """Values (n, 3) and winners (n,).

    Args:
        wish: T, positive to the left: (n,).
        dead_band: δ, 0 or more, in the unit of T.
    """
    stay = np.full_like(wish, dead_band)
    q_values = np.stack([stay, wish, -wish], axis=1).astype(np.float32)
    return q_values, q_values.argmax(axis=1)


def preferring_to_stay(values: Floats, preference: float) -> tuple[QValues, Actions]:
    """Values (n, 3) and winners (n,) where staying is worth a little more than it seems.

    Args:
        values: of the three actions: (n, 3).
        preference: of staying, in their unit.
    """
    added = np.zeros(values.shape[1], np.float32)
    added[STAY] = preference
    q_values: QValues = (values + added).astype(np.float32)
    return q_values, q_values.argmax(axis=1)
