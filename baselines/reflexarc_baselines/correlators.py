"""Motion detectors of the insect's eye: each correlates two receptors, one of them late.

    s̄ ← s̄ + (1 − β)(s − s̄),   β = e^(−Δt/τ)
    m = s̄_a s_b − s_a s̄_b      positive for what moves from a to b

Source: B. Hassenstein and W. Reichardt, *Systemtheoretische Analyse der Zeit-, Reihenfolgen- und
Vorzeichenauswertung bei der Bewegungsperzeption des Rüsselkäfers Chlorophanus*, 1956. It is no
speedometer: its answer depends on contrast and pattern, and it is largest at one temporal
frequency. In the mean, for a sine of amplitude C and wavelength λ that passes with the frequency f
two receptors Δφ apart, and ω = 2πfΔt,

    ⟨m⟩ = C² sin(2πΔφ/λ) (1 − β) β sin ω / (1 − 2β cos ω + β²)

It takes arrays of any shape and of either precision.
"""

import math
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.contract.eye import RetinaSpec

_Signal = TypeVar("_Signal", npt.NDArray[np.float32], npt.NDArray[np.float64])


def kept_share(period_s: float, time_constant_s: float) -> float:
    """β: what of a low-passed signal is left after a period."""
    return math.exp(-period_s / time_constant_s)


def low_passed(late: _Signal, now: _Signal, kept: _Signal) -> _Signal:
    """s̄ after one more look.

    Args:
        late: s̄ before it.
        now: s, what is seen.
        kept: β.
    """
    return late + (1 - kept) * (now - late)


def motion(a: _Signal, late_a: _Signal, b: _Signal, late_b: _Signal) -> _Signal:
    """m: how strongly something seems to move from receptor a to receptor b.

    Args:
        a: s_a.
        late_a: s̄_a, which has s_a in it already.
        b: s_b.
        late_b: s̄_b.
    """
    return late_a * b - a * late_b


def receptors(eye: RetinaSpec, bearings_rad: npt.NDArray[np.float64]) -> Floats:
    """Receptors that look anywhere, each a mean of the two rays beside its bearing.

    Beyond the outermost rays it is the outermost ray.

    Args:
        eye: whose rays.
        bearings_rad: where they look, to the left positive: (..., receptors).

    Returns:
        What to multiply a row of rays by: (..., rays, receptors).
    """
    at = (eye.rays - 1) / 2.0 - bearings_rad / (eye.fov_rad / eye.rays)
    at = np.clip(at, 0.0, eye.rays - 1.0)[..., np.newaxis, :]
    rays = np.arange(eye.rays)[:, np.newaxis]
    shares: Floats = np.clip(1.0 - np.abs(rays - at), 0.0, 1.0).astype(np.float32)
    return shares
