"""Optic flow between the last two frames: how fast what each ray sees glides past, in rad/s.

The gradient scheme: brightness that only moves keeps I_t + ω I_φ = 0, so, kept finite by κ,

    F = −I_t I_φ / (I_φ² + κ)

with I_t the change a second and I_φ the slope along the bearing, of the mean of both frames. Where
there is no slope nothing is seen to move, and F is 0: F is small rather than wrong.

Its limits: what moves farther than a ray in one period is not followed (v Δt / d ≤ δφ: 0.5 m away
with 16 rays at 1 m/s and 10 Hz), and every motion is seen, the body's own too: a step aside with u
changes the sum of the side moved to by 1 − 2u / πv, and that of the other by 1 + 2u / πv.
"""

import math

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.sensing.ray_values import FULL_SCALE

SPEED_MPS, ASIDE_MPS = 1.0, 0.25
"""Slow sidesteps: at equal speeds a body that always looks mostly sees its own."""
SILENCE = 1e-3
"""Flow of a side that is next to none: a thousandth of a radian a second."""
RATE_HZ, MAX_INPUT_AGE_S = 10.0, 0.25
"""On a robot as on the reference field: more often, frames differ by less than their 256 steps."""


def flow_contract() -> PolicyContract:
    """Two frames of colour, with soft edges: nearness changes with the distance, which is no flow.

    More rays would see less, not more: what is near glides past several of them in a period.
    """
    eye = RetinaSpec(
        rays=16, fov_rad=math.pi, range_m=5.0, shading=Shading.COLOUR, frames=2, samples=16
    )
    return PolicyContract(
        retina=eye,
        actions=sideways_actions(SPEED_MPS, ASIDE_MPS),
        rate_hz=RATE_HZ,
        max_input_age_s=MAX_INPUT_AGE_S,
    )


def frames_of(retinas: RetinaBatch) -> tuple[Floats, Floats]:
    """Brightness in the last frame but one and in the last, first eye, 0 to 1: (n, rays) each."""
    last = retinas[:, -2:, 0].astype(np.float32) / np.float32(FULL_SCALE)
    grey: Floats = last.mean(axis=-1, dtype=np.float32)
    return grey[:, 0], grey[:, 1]


def gradient_flow(retinas: RetinaBatch, eye: RetinaSpec, period_s: float, kappa: float) -> Floats:
    """F of each ray, counter-clockwise positive: (n, rays).

    Args:
        retinas: of two frames or more.
        eye: how far apart its rays look.
        period_s: time between two frames.
        kappa: κ, in squares of brightness a radian.
    """
    before, now = frames_of(retinas)
    rate = (now - before) / np.float32(period_s)
    sector_rad = np.float32(eye.fov_rad / eye.rays)
    # The first ray is the leftmost: bearings fall along the row.
    slope = -_rises((before + now) * np.float32(0.5)) / sector_rad
    flow: Floats = (-rate * slope / (slope**2 + np.float32(kappa))).astype(np.float32)
    return flow


def outward(flow: Floats) -> Floats:
    """The same, positive where it goes from ahead to behind on either side: (n, rays)."""
    rays = flow.shape[1]
    signs = np.where(np.arange(rays) < rays / 2, np.float32(1.0), np.float32(-1.0))
    return flow * signs


def sides(values: Floats) -> tuple[Floats, Floats]:
    """Mean of the left half of the rays, and of the right half: (n,) each."""
    half = values.shape[1] // 2
    left: Floats = values[:, :half].mean(axis=1)
    right: Floats = values[:, -half:].mean(axis=1)
    return left, right


def balance(left: Floats, right: Floats, silence: float = SILENCE) -> Floats:
    """Δ = (L − R) / (L + R + ε), −1 to 1; what goes inward counts as none: (n,).

    ε lets two sides that are all but silent be in balance, so that no jump hangs on rounding.

    Args:
        left: outward flow of the left side: (n,).
        right: the same of the right side.
        silence: ε, in the unit of the flow.
    """
    left, right = np.maximum(left, np.float32(0.0)), np.maximum(right, np.float32(0.0))
    index: Floats = (left - right) / (left + right + np.float32(silence))
    return index


def _rises(row: Floats) -> Floats:
    """By how much each row rises from ray to ray, at the ends by one step: (n, rays).

    `np.gradient` says the same; of it no graph can be written.
    """
    inside = (row[:, 2:] - row[:, :-2]) * np.float32(0.5)
    first, last = row[:, 1:2] - row[:, :1], row[:, -1:] - row[:, -2:-1]
    return np.concatenate([first, inside, last], axis=1)
