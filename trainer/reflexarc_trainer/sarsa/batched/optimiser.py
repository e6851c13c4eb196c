r"""The optimisers Adam and RAdam, compiled; the same arithmetic as torch's (the tests compare).

For a gradient g, and t counting the updates from 1:

    m ← β₁m + (1 − β₁)g,   v ← β₂v + (1 − β₂)g²,   m̂ = m / (1 − β₁ᵗ),   v̂ = v / (1 − β₂ᵗ)
    Adam:   w ← w − α m̂ / (√v̂ + ε)                                  (arXiv 1412.6980)
    RAdam:  w ← w − α r m̂ / (√v̂ + ε), where r is the rectification of the variance of v̂;
            w ← w − α m̂ at the first updates, when that variance is not defined
                                                                    (arXiv 1908.03265)

with the learning rate α. A gradient longer than a limit is first shortened to it.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8
"""β₁, β₂ and ε as published, which are torch's defaults."""
_RHO_MAX = 2.0 / (1.0 - BETA_2) - 1.0
"""ρ∞, the longest length of RAdam's simple moving average."""
_RHO_LEAST = 5.0
"""The variance of v̂ counts as defined above this length of the average, as in torch."""
_NORM_EPSILON = 1e-6
"""As in torch's `clip_grad_norm_`."""

Vector = npt.NDArray[Any]


class Moments(NamedTuple):
    """What the optimiser carries from update to update."""

    first: Vector
    """m, running mean of the gradients: (parameters,)."""
    second: Vector
    """v, running mean of their squares: (parameters,)."""
    updates: npt.NDArray[np.int64]
    """t, updates so far: (1,)."""


def new_moments(parameters: int, dtype: npt.DTypeLike) -> Moments:
    """The moments before the first update."""
    return Moments(np.zeros(parameters, dtype), np.zeros(parameters, dtype), np.zeros(1, np.int64))


@fused
def clip_norm(gradient: Vector, longest: float) -> float:
    """Shorten a gradient (parameters,) to a norm of at most `longest`; returns its former norm."""
    total = 0.0
    for k in range(len(gradient)):
        total += float(gradient[k]) * float(gradient[k])
    norm = math.sqrt(total)
    if norm > longest:
        share = gradient.dtype.type(longest / (norm + _NORM_EPSILON))
        for k in range(len(gradient)):
            gradient[k] *= share
    return norm


@fused
def descend(
    weights: Vector, gradient: Vector, moments: Moments, learning_rate: float, rectified: bool
) -> None:
    """Update the weights once, against the gradient.

    Args:
        weights: w: (parameters,).
        gradient: g: (parameters,).
        moments: updated.
        learning_rate: α.
        rectified: RAdam; else Adam.
    """
    moments.updates[0] += 1
    count = float(moments.updates[0])
    correction_1, correction_2 = 1.0 - BETA_1**count, 1.0 - BETA_2**count
    rho = _RHO_MAX - 2.0 * count * BETA_2**count / correction_2
    adaptive = not rectified or rho > _RHO_LEAST
    step = learning_rate / correction_1
    if rectified and adaptive:
        step *= _rectification(rho)
    _move(weights, gradient, moments, step, math.sqrt(correction_2), adaptive)


@fused
def _rectification(rho: float) -> float:
    """The factor r of RAdam for an average of length ρ."""
    above = (rho - 4.0) * (rho - 2.0) * _RHO_MAX
    below = (_RHO_MAX - 4.0) * (_RHO_MAX - 2.0) * rho
    return math.sqrt(above / below)


@fused
def _move(
    weights: Vector,
    gradient: Vector,
    moments: Moments,
    step: float,
    root_correction: float,
    adaptive: bool,
) -> None:
    """Update the moments, then w ← w − step · m / (√v / root_correction + ε)."""
    number = weights.dtype.type
    keep_1, keep_2 = number(BETA_1), number(BETA_2)
    take_1, take_2 = number(1.0 - BETA_1), number(1.0 - BETA_2)
    stride, root, least = number(step), number(root_correction), number(EPSILON)
    first, second = moments.first, moments.second
    for k in range(len(weights)):
        g = gradient[k]
        first[k] = keep_1 * first[k] + take_1 * g
        second[k] = keep_2 * second[k] + take_2 * g * g
    for k in range(len(weights)):
        scale = np.sqrt(second[k]) / root + least if adaptive else number(1.0)
        weights[k] -= stride * first[k] / scale
