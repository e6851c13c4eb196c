r"""The trace and the four sizes of a step; compiled, over vectors of any network.

    e ← γλ e + ∇Q(s, a),        w ← w + step · δ · e

    literal       step = α
    bounded       step = min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁))                   (arXiv 2410.14606)
    intentional   step = α s / Σ s e²,  s = 1 / RMS(∇Q) for each weight         (arXiv 2604.19033)
    rmsprop       step = α s,           s = 1 / RMS(δe) for each weight         (Tieleman & Hinton,
                                        Lecture 6.5, COURSERA: Neural Networks for ML, 2012)

The intentional step removes the share α of the TD error where the trace is the gradient (λ = 0);
its δ is cut at 20 times its running RMS.

The step by RMS takes s anew at every sixteenth update, for roots and divisions take longer than all
the rest, and at each of the first 64, of which the very first has none and moves nothing. What a
weight's δe has grown to since is cut at a hundred times its RMS.
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
"""Code of each rule."""

_LEAST = 1e-12
_FORGOTTEN = 1e-30
"""A smaller trace is none. Left to decay, it would end among the subnormal numbers, on which every
operation takes a hundred times as long; so would a mean of squares, to which this is added."""


@fused_disjoint
def accumulate(trace: Floats, gradient: Floats, decay: float) -> float:
    """Do e ← γλ e + ∇Q; returns ‖e‖₁. All arguments but the `decay` γλ are (parameters,)."""
    number = trace.dtype.type
    kept, least, zero = number(decay), number(_FORGOTTEN), number(0)
    norm = zero
    for k in range(len(trace)):
        e = kept * trace[k] + gradient[k]
        e = e if abs(e) > least else zero
        trace[k] = e
        norm += abs(e)
    return float(norm)


@fused_inline
def bounded_step(alpha: float, kappa: float, td_error: float, norm: float) -> float:
    """The step that is never above α and never removes more than 1/κ of the TD error."""
    bound = kappa * max(1.0, abs(td_error)) * norm
    return min(alpha, 1.0 / bound) if bound > 0.0 else alpha


@fused_disjoint
def move(weights: Floats, trace: Floats, change: float) -> None:
    """Do w ← w + change · e."""
    factor = weights.dtype.type(change)
    for k in range(len(weights)):
        weights[k] += factor * trace[k]


@fused_inline
def move_intentionally(
    weights: Floats, trace: Floats, squares: Floats, gradient: Floats, change: float
) -> None:
    """Do w ← w + change · s e / Σ s e²; updates the running mean of ∇Q². `change` is αδ."""
    number = weights.dtype.type
    keep, take, least = number(SQUARES_KEPT), number(1.0 - SQUARES_KEPT), number(_LEAST)
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
    """Do w ← w + α s δe; updates the running mean of (δe)². All arrays are (parameters,)."""
    number = weights.dtype.type
    error, size, largest = number(td_error), number(alpha), number(LARGEST_RATIO)
    keep, take, least = number(SQUARES_KEPT), number(1.0 - SQUARES_KEPT), number(_FORGOTTEN)
    for k in range(len(weights)):
        change = error * trace[k]
        squares[k] = keep * squares[k] + (take * change * change + least)
        weights[k] += size * min(max(change * scales[k], -largest), largest)


@fused_disjoint
def rescale(squares: Floats, scales: Floats, known: float) -> None:
    """Take s anew from the running means, which hold the share `known` of what they will."""
    number = squares.dtype.type
    one, per_known, least = number(1), number(1.0 / known), number(LEAST_RMS)
    for k in range(len(squares)):
        scales[k] = one / (np.sqrt(squares[k] * per_known) + least)


@fused_inline
def cut_td_error(td_error: float, mean_square: float, step: int) -> float:
    """δ, at most `LARGEST_TD_ERROR` times its RMS; `mean_square` begins at 0 and counts steps."""
    known = 1.0 - SQUARES_KEPT**step
    limit = LARGEST_TD_ERROR * math.sqrt(mean_square / known)
    return min(max(td_error, -limit), limit)
