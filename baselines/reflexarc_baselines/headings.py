"""Where the motions of a contract lead, and how far each is free as the rays see it."""

import math

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.contract.contract import PolicyContract


def headings_rad(contract: PolicyContract) -> tuple[float, ...]:
    """Direction in which each action moves the body, to the left positive."""
    return tuple(math.atan2(a.lateral_mps, a.linear_mps) for a in contract.actions)


def free_along_m(
    distances_m: Floats, bearings_rad: Floats, headings_rad: tuple[float, ...], rays: int
) -> Floats:
    """What the shortest of the rays nearest to each heading measures: (n, headings).

    Args:
        distances_m: of what each ray meets: (n, rays).
        bearings_rad: where the rays look: (rays,).
        headings_rad: directions to look along.
        rays: how many are asked for each heading.
    """
    nearest = [np.argsort(np.abs(bearings_rad - h), kind="stable")[:rays] for h in headings_rad]
    free: Floats = np.stack([distances_m[:, own].min(axis=1) for own in nearest], axis=1)
    return free
