"""Reichardt's correlator between neighbouring rays: who sees it first says where it goes.

Source: B. Hassenstein and W. Reichardt, 1956, by its usual form. From each signal its slow mean is
subtracted, without which the correlator follows brightness; then, with β = e^(−Δt/τ),

    s̄ ← s̄ + (1 − β)(s − s̄),     m = s̄_a s_b − s_a s̄_b,     positive from a to b

For a grating C sin of wavelength λ that passes with f periods a second, ω = 2πfΔt, and rays Δφ
apart:

    ⟨m⟩ = C² sin(2πΔφ/λ) · (1 − β) β sin ω / (1 − 2β cos ω + β²)

So it is no speedometer: it falls with the square of the contrast, has an optimum at a number of
periods a second, not at a speed, and turns its sign between Δφ and 2Δφ of wavelength.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import Memories


@dataclass(frozen=True)
class Filters:
    """The two filters of every ray, by what they keep in one period."""

    delay_keeps: float
    """β of the delay."""
    mean_keeps: float
    """β of the slow mean."""

    @classmethod
    def of(cls, delay_s: float, mean_s: float, period_s: float) -> Self:
        """Those of two time constants."""
        return cls(math.exp(-period_s / delay_s), math.exp(-period_s / mean_s))

    def followed(self, brightness: Floats, memory: Memories) -> tuple[Floats, Floats, Memories]:
        """Signals without their means, those delayed, (n, rays) each, and what is remembered.

        Args:
            brightness: of the newest frame: (n, rays).
            memory: whether it has begun, means, delayed signals: (n, 1 + 2 rays); zeros at the
                start, when the first frame is its own mean.
        """
        rays = brightness.shape[1]
        means = np.where(memory[:, :1] > 0.0, memory[:, 1 : 1 + rays], brightness)
        means = means + np.float32(1.0 - self.mean_keeps) * (brightness - means)
        signals: Floats = brightness - means
        delayed = memory[:, 1 + rays :]
        delayed = delayed + np.float32(1.0 - self.delay_keeps) * (signals - delayed)
        begun = np.ones((len(memory), 1), np.float32)
        return signals, delayed, np.concatenate([begun, means, delayed], axis=1)


def leftward(signals: Floats, delayed: Floats) -> Floats:
    """The correlators' m from each ray to its left neighbour, as rays go by: (n, rays − 1)."""
    to_signals, from_signals = signals[:, :-1], signals[:, 1:]
    return delayed[:, 1:] * to_signals - from_signals * delayed[:, :-1]
