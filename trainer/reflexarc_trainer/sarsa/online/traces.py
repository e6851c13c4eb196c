r"""The eligibility trace and the four step rules; compiled, over the weights as one vector.

    e ← γλ e + ∇Q(s, a),        w ← w + step · δ · e

    literal       step = α
    bounded       step = min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁))                   (arXiv 2410.14606)
    intentional   step = α s / Σ s e²,  s = 1 / RMS(∇Q) for each weight         (arXiv 2604.19033)
    rmsprop       step = α s,           s = 1 / RMS(δe) for each weight         (Tieleman & Hinton,
                                        Lecture 6.5, COURSERA: Neural Networks for ML, 2012)

The intentional step removes the share α of the TD error if the trace is the gradient (λ = 0); its
δ is clipped at 20 times its running RMS.

The step by RMS recomputes s at every 16th update only, for roots and divisions take longer than
the rest of an update, and at each of the first 64. At the very first, s is 0 and no weight moves.
Between two of these updates s · δe can exceed 1 by far; it is clipped at 100.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused_disjoint, fused_inline
from reflexarc_trainer.sarsa.step_rules import (
    LARGEST_RATIO,
    LARGEST_TD_ERROR,
    LEAST_RMS,
    LEAST_TOTAL,
    SQUARES_KEPT,
)

Floats = npt.NDArray[np.floating]

LITERAL, BOUNDED, INTENTIONAL, RMSPROP = range(4)
STEP_RULES = {
    "literal": LITERAL,
    "bounded": BOUNDED,
    "intentional": INTENTIONAL,
    "rmsprop": RMSPROP,
}
"""Code of each step rule of the configuration."""

_LEAST_ROOT = 1e-12
"""Intentional step: added to RMS(∇Q) before the division."""
_NEGLIGIBLE = 1e-30
"""A smaller entry of the trace becomes 0. It would decay into the subnormal numbers, on which every
operation takes a hundred times as long. For the same reason it is added to the mean of (δe)²."""


@fused_disjoint
def accumulate(trace: Floats, gradient: Floats, decay: float) -> float:
    """Do e ← γλ e + ∇Q.

    Args:
        trace: e: (parameters,).
        gradient: ∇Q(s, a): (parameters,).
        decay: γλ.

    Returns:
        ‖e‖₁.
    """
    number = trace.dtype.type
    kept, least, zero = number(decay), number(_NEGLIGIBLE), number(0)
    norm = zero
    for k in range(len(trace)):
        e = kept * trace[k] + gradient[k]
        e = e if abs(e) > least else zero
        trace[k] = e
        norm += abs(e)
    return float(norm)


@fused_inline
def bounded_step(alpha: float, kappa: float, td_error: float, norm: float) -> float:
    """The largest step up to α that removes at most 1/κ of the TD error; `norm` is ‖e‖₁."""
    bound = kappa * max(1.0, abs(td_error)) * norm
    return min(alpha, 1.0 / bound) if bound > 0.0 else alpha


@fused_disjoint
def move(weights: Floats, trace: Floats, change: float) -> None:
    """Do w ← w + change · e; `change` is step · δ."""
    factor = weights.dtype.type(change)
    for k in range(len(weights)):
        weights[k] += factor * trace[k]


@fused_inline
def move_intentionally(
    weights: Floats, trace: Floats, squares: Floats, gradient: Floats, change: float
) -> None:
    """Do w ← w + αδ · s e / Σ s e², and update the running mean of (∇Q)².

    Args:
        weights: w: (parameters,).
        trace: e: (parameters,).
        squares: the running mean: (parameters,).
        gradient: ∇Q(s, a): (parameters,).
        change: αδ.
    """
    number = weights.dtype.type
    keep, take, least = (
        number(SQUARES_KEPT),
        number(1.0 - SQUARES_KEPT),
        number(_LEAST_ROOT),
    )
    total = number(0)
    for k in range(len(weights)):
        square = keep * squares[k] + take * gradient[k] * gradient[k]
        squares[k] = square
        total += trace[k] * trace[k] / (np.sqrt(square) + least)
    share = number(change / total if total > LEAST_TOTAL else 0.0)
    for k in range(len(weights)):
        weights[k] += share * trace[k] / (np.sqrt(squares[k]) + least)


@fused_disjoint
def move_by_rms(
    weights: Floats,
    trace: Floats,
    squares: Floats,
    scales: Floats,
    td_error: float,
    alpha: float,
) -> None:
    """Do w ← w + α s δe, and update the running mean of (δe)².

    Args:
        weights: w: (parameters,).
        trace: e: (parameters,).
        squares: the running mean: (parameters,).
        scales: s, as `rescale` last computed it: (parameters,).
        td_error: δ.
        alpha: α.
    """
    number = weights.dtype.type
    error, size, largest = number(td_error), number(alpha), number(LARGEST_RATIO)
    keep, take, least = number(SQUARES_KEPT), number(1.0 - SQUARES_KEPT), number(_NEGLIGIBLE)
    for k in range(len(weights)):
        change = error * trace[k]
        squares[k] = keep * squares[k] + (take * change * change + least)
        weights[k] += size * min(max(change * scales[k], -largest), largest)


@fused_disjoint
def rescale(squares: Floats, scales: Floats, known: float) -> None:
    """Recompute s from the running means of (δe)².

    Args:
        squares: the running means, which began at 0: (parameters,).
        scales: s, filled: (parameters,).
        known: sum of the weights that the mean has given to its updates so far, by which it is
            divided to remove its bias towards 0.
    """
    number = squares.dtype.type
    one, per_known, least = number(1), number(1.0 / known), number(LEAST_RMS)
    for k in range(len(squares)):
        scales[k] = one / (np.sqrt(squares[k] * per_known) + least)


@fused_inline
def clip_td_error(td_error: float, mean_square: float, step: int) -> float:
    """δ, clipped at `LARGEST_TD_ERROR` times its running RMS.

    Args:
        td_error: δ.
        mean_square: running mean of δ², which began at 0.
        step: updates of that mean so far, 1 or more.
    """
    known = 1.0 - SQUARES_KEPT**step
    limit = LARGEST_TD_ERROR * math.sqrt(mean_square / known)
    return min(max(td_error, -limit), limit)
