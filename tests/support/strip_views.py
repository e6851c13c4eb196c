"""What two eyes see of strips across the way, drawn exactly: of each ray the share that is lit."""

import math

import numpy as np
import numpy.typing as npt

RAYS, FOV_RAD, BASELINE_M = 16, 2 * math.pi / 3, 0.2
SECTOR_RAD = FOV_RAD / RAYS


def view(strips: list[tuple[float, float, float]], eye_y_m: float) -> npt.NDArray[np.float32]:
    """What an eye at (0, eye_y) that looks ahead sees of strips (depth, right end, left end).

    Returns:
        Of each ray the lit share of its sector, (1, RAYS).
    """
    lit = np.zeros((1, RAYS), np.float32)
    for depth, right_m, left_m in strips:
        left_rad, right_rad = (math.atan2(y - eye_y_m, depth) for y in (left_m, right_m))
        for ray in range(RAYS):
            high = FOV_RAD * (0.5 - ray / RAYS)
            inside = min(left_rad, high) - max(right_rad, high - SECTOR_RAD)
            lit[0, ray] += max(0.0, inside) / SECTOR_RAD
    return np.minimum(lit, np.float32(1.0))
