"""A straight corridor of sine gratings seen by the flow eye, by sums over fine sub-rays, slowly."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import RetinaBatch

RAYS, FINE, FOV_RAD = 16, 64, math.pi
HAZE_M = 8.0
Floats = npt.NDArray[np.float64]


def bearings_rad(count: int) -> Floats:
    """Middles of equal sectors, the leftmost first."""
    return FOV_RAD * (0.5 - (np.arange(count) + 0.5) / count)


def rays_of(shades: Floats, rays: int = RAYS) -> Floats:
    """Mean of the sub-rays of each ray: (rays,)."""
    return shades.reshape(rays, -1).mean(axis=1)


def corridor(
    x_m: float, y_m: float, period_m: float, *, half_m: float = 1.0, rays: int = RAYS
) -> Floats:
    """What is seen from a place between walls at ± half a width, through haze: (rays,)."""
    bearings = bearings_rad(rays * FINE)
    walls_m = np.where(bearings > 0.0, half_m - y_m, half_m + y_m)
    along_m = x_m + walls_m / np.abs(np.tan(bearings))
    away_m = walls_m / np.abs(np.sin(bearings))
    contrast = np.maximum(1.0 - away_m / HAZE_M, 0.0)
    return rays_of(0.5 + 0.5 * contrast * np.sin(2.0 * math.pi * along_m / period_m), rays)


def bar(left_rad: float, right_rad: float, shade: float, background: float) -> Floats:
    """A bar of one shade between two bearings before a background: (rays,)."""
    bearings = bearings_rad(RAYS * 4096)
    is_bar = (bearings < left_rad) & (bearings > right_rad)
    return rays_of(np.where(is_bar, shade, background))


def two_frames(before: Floats, now: Floats) -> RetinaBatch:
    """As an eye would give them, in 256 steps: (1, 2, 1, rays, 1)."""
    seen = np.stack([before, now])
    return np.round(255.0 * seen).astype(np.uint8)[np.newaxis, :, np.newaxis, :, np.newaxis]
