"""Rays of a retina as numbers: their brightness, their bearings and, in white worlds, distances."""

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.sensing.ray_values import FULL_SCALE


def brightness(retinas: RetinaBatch) -> Floats:
    """Of the newest frame, first eye, mean over the channels, 0 to 1: (n, rays).

    Args:
        retinas: uint8 (n, frames, eyes, rays, channels).
    """
    newest = retinas[:, -1, 0].astype(np.float32) / np.float32(FULL_SCALE)
    values: Floats = newest.mean(axis=-1, dtype=np.float32)
    return values


def distances_m(retinas: RetinaBatch, eye: RetinaSpec) -> Floats:
    """Distance of what each ray meets, r = S(1 − I); S where it meets nothing: (n, rays).

    Args:
        retinas: of an eye with shading `nearness`, in a white world.
        eye: whose range S is.
    """
    return np.float32(eye.range_m) * (np.float32(1.0) - brightness(retinas))


def bearings_rad(eye: RetinaSpec) -> Floats:
    """Where the rays look, to the left positive, the leftmost first: (rays,)."""
    sector_rad = eye.fov_rad / eye.rays
    middle = (eye.rays - 1) / 2.0
    return np.array([(middle - i) * sector_rad for i in range(eye.rays)], np.float32)
