"""Correlators between neighbouring rays: who sees it first says where it goes.

The detector and its source are in `correlators.py`. From each signal its slow mean is subtracted,
without which the correlator follows brightness. It is no speedometer: it falls with the square of
the contrast, has an optimum at a number of periods a second, not at a speed, and turns its sign
between Δφ and 2Δφ of wavelength.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.correlators import kept_share, low_passed, motion
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
        return cls(kept_share(period_s, delay_s), kept_share(period_s, mean_s))

    def followed(self, brightness: Floats, memory: Memories) -> tuple[Floats, Floats, Memories]:
        """Signals without their means, those delayed, (n, rays) each, and what is remembered.

        Args:
            brightness: of the newest frame: (n, rays).
            memory: whether it has begun, means, delayed signals: (n, 1 + 2 rays); zeros at the
                start, when the first frame is its own mean.
        """
        rays = brightness.shape[1]
        means = np.where(memory[:, :1] > 0.0, memory[:, 1 : 1 + rays], brightness)
        means = low_passed(means, brightness, np.float32(self.mean_keeps))
        signals: Floats = brightness - means
        delayed = memory[:, 1 + rays :]
        delayed = low_passed(delayed, signals, np.float32(self.delay_keeps))
        begun = np.ones((len(memory), 1), np.float32)
        return signals, delayed, np.concatenate([begun, means, delayed], axis=1)


def leftward(signals: Floats, delayed: Floats) -> Floats:
    """The correlators' m from each ray to its left neighbour, as rays go by: (n, rays − 1)."""
    return motion(signals[:, 1:], delayed[:, 1:], signals[:, :-1], delayed[:, :-1])
