r"""The trace and the three sizes of a step; compiled, over vectors of any network.

    e ← γλ e + ∇Q(s, a),        w ← w + step · δ · e

    literal       step = α
    bounded       step = min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁))                   (arXiv 2410.14606)
    intentional   step = α s / Σ s e²,  s = 1 / RMS(∇Q) for each weight         (arXiv 2604.19033)

The intentional step removes the share α of the TD error where the trace is the gradient (λ = 0);
its δ is cut at 20 times its running RMS.
"""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.fused import fused_disjoint, fused_inline

Floats = npt.NDArray[np.float64]

LITERAL, BOUNDED, INTENTIONAL = range(3)
STEP_RULES = {"literal": LITERAL, "bounded": BOUNDED, "intentional": INTENTIONAL}
"""Code of each rule."""

SQUARES_KEPT = 0.999
"""What the running means of squares keep at each step."""
LARGEST_TD_ERROR = 20.0
"""In multiples of its running RMS (arXiv 2604.19033)."""
_LEAST = 1e-12
_FORGOTTEN = 1e-100
"""A smaller trace is none. Left to decay, it would end among the subnormal numbers, on which every
operation takes a hundred times as long."""


@fused_disjoint
def accumulate(trace: Floats, gradient: Floats, decay: float) -> float:
    """Do e ← γλ e + ∇Q; returns ‖e‖₁. All arguments but the `decay` γλ are (parameters,)."""
    norm = 0.0
    for k in range(len(trace)):
        e = decay * trace[k] + gradient[k]
        e = e if abs(e) > _FORGOTTEN else 0.0
        trace[k] = e
        norm += abs(e)
    return norm


@fused_inline
def bounded_step(alpha: float, kappa: float, td_error: float, norm: float) -> float:
    """The step that is never above α and never removes more than 1/κ of the TD error."""
    bound = kappa * max(1.0, abs(td_error)) * norm
    return min(alpha, 1.0 / bound) if bound > 0.0 else alpha


@fused_disjoint
def move(weights: Floats, trace: Floats, change: float) -> None:
    """Do w ← w + change · e."""
    for k in range(len(weights)):
        weights[k] += change * trace[k]


@fused_inline
def move_intentionally(
    weights: Floats, trace: Floats, squares: Floats, gradient: Floats, change: float
) -> None:
    """Do w ← w + change · s e / Σ s e²; updates the running mean of ∇Q². `change` is αδ."""
    total = 0.0
    for k in range(len(weights)):
        square = SQUARES_KEPT * squares[k] + (1.0 - SQUARES_KEPT) * gradient[k] * gradient[k]
        squares[k] = square
        total += trace[k] * trace[k] / (np.sqrt(square) + _LEAST)
    share = change / total if total > 0.0 else 0.0
    for k in range(len(weights)):
        weights[k] += share * trace[k] / (np.sqrt(squares[k]) + _LEAST)


@fused_inline
def cut_td_error(td_error: float, mean_square: float, step: int) -> float:
    """δ, at most `LARGEST_TD_ERROR` times its RMS; `mean_square` begins at 0 and counts steps."""
    known = 1.0 - SQUARES_KEPT**step
    limit = LARGEST_TD_ERROR * math.sqrt(mean_square / known)
    return min(max(td_error, -limit), limit)
