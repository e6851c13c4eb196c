"""How soon something that swells will be met: its time to contact, from its angle alone.

Source: D. N. Lee's τ (1976): α / α̇ of what subtends α. For a flat face sin α / α̇ is the exact time
to it, for a disc's centre 2 tan(α/2) / α̇; α / α̇ itself is 13 % too long at 48°. Used here is

    τ = sin α / α̇

of the bright or dark run of rays ahead: from the ray that stands out most within the front, to
either side as far as rays stand out, of the brightest (or darkest) of the retina. α is the width of
the run, its partly covered rays counted by how much they stand out.
"""

from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.history.flow.optic_flow import frames_of
from reflexarc_baselines.rays import bearings_rad
from reflexarc_runtime.arrays import Mask, RetinaBatch
from reflexarc_runtime.contract.eye import RetinaSpec

STANDS_OUT = 0.02
"""Least brightness over the background, or below it, of a run."""
NEVER_S = np.float32(1e6)
"""τ of what does not swell, and where there is no run."""


@dataclass(frozen=True)
class Looming:
    """The run that will be met first."""

    tau_s: Floats
    """Until it is met: (n,)."""
    bearing_rad: Floats
    """Where its middle is: (n,)."""


def looming(retinas: RetinaBatch, eye: RetinaSpec, front_rad: float, period_s: float) -> Looming:
    """The bright or the dark run ahead, whichever comes sooner.

    Args:
        retinas: of two frames or more.
        eye: where its rays look.
        front_rad: how far from ahead a run may stand out most.
        period_s: time between two frames.
    """
    before, now = frames_of(retinas)
    bright = _of_run(_over(before), _over(now), eye, front_rad, period_s)
    dark = _of_run(_over(1.0 - before), _over(1.0 - now), eye, front_rad, period_s)
    is_bright = bright.tau_s <= dark.tau_s
    return Looming(
        np.where(is_bright, bright.tau_s, dark.tau_s),
        np.where(is_bright, bright.bearing_rad, dark.bearing_rad),
    )


def tau_s(alpha_rad: Floats, alpha_before_rad: Floats, period_s: float) -> Floats:
    """τ = sin α / α̇ of angles one period apart, in their middle: (n,)."""
    rate = (alpha_rad - alpha_before_rad) / np.float32(period_s)
    middle = np.sin((alpha_rad + alpha_before_rad) * np.float32(0.5))
    tau = np.full_like(rate, NEVER_S)
    np.divide(middle, rate, out=tau, where=rate > 1e-6)
    return np.minimum(tau, NEVER_S)


def _over(brightness: Floats) -> Floats:
    """How much each ray stands out from the darkest: (n, rays)."""
    above: Floats = brightness - np.min(brightness, axis=1)[:, np.newaxis]
    return above


def _of_run(
    before: Floats, now: Floats, eye: RetinaSpec, front_rad: float, period_s: float
) -> Looming:
    bearings = bearings_rad(eye)
    ahead = np.where(np.abs(bearings) <= front_rad, now, np.float32(-1.0))
    peak = ahead.argmax(axis=1)
    height = now[np.arange(len(now)), peak]
    widths = [_shares(values, peak, height) for values in (before, now)]
    sector_rad = np.float32(eye.fov_rad / eye.rays)
    alphas = [shares.sum(axis=1) * sector_rad for shares in widths]
    is_whole = (widths[1][:, 0] + widths[1][:, -1] == 0.0) & (alphas[0] > 0.0)
    tau = np.where(is_whole, tau_s(alphas[1], alphas[0], period_s), NEVER_S)
    weight = np.maximum(widths[1].sum(axis=1), np.float32(1e-6))
    return Looming(tau, (widths[1] * bearings).sum(axis=1) / weight)


def _shares(values: Floats, peak: np.ndarray, height: Floats) -> Floats:
    """How much of each ray the run around the peak covers: (n, rays)."""
    stands_out: Mask = values > STANDS_OUT
    gaps = np.cumsum(~stands_out, axis=1)
    is_run = stands_out & (gaps == np.take_along_axis(gaps, peak[:, np.newaxis], axis=1))
    shares = values / np.maximum(height, np.float32(STANDS_OUT))[:, np.newaxis]
    return np.where(is_run, np.minimum(shares, np.float32(1.0)), np.float32(0.0))
