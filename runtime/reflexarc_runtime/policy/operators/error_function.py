"""The error function, erf(x) = 2/√π ∫₀ˣ exp(−t²) dt, in float64: NumPy has none.

Rational approximations of W. J. Cody, "Rational Chebyshev approximations for the error function",
Mathematics of Computation 23 (1969): of erf up to 0.5, of exp(x²)·erfc(x) beyond. Sums and products
alone, but for one exponential, so every machine finds the same to the last bits.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_NEAR = (
    (
        1.85777706184603153e-1,
        3.16112374387056560e0,
        1.13864154151050156e2,
        3.77485237685302021e2,
        3.20937758913846947e3,
    ),
    (
        1.0,
        2.36012909523441209e1,
        2.44024637934444173e2,
        1.28261652607737228e3,
        2.84423683343917062e3,
    ),
)
_FAR = (
    (
        2.15311535474403846e-8,
        5.64188496988670089e-1,
        8.88314979438837594e0,
        6.61191906371416295e1,
        2.98635138197400131e2,
        8.81952221241769090e2,
        1.71204761263407058e3,
        2.05107837782607147e3,
        1.23033935479799725e3,
    ),
    (
        1.0,
        1.57449261107098347e1,
        1.17693950891312499e2,
        5.37181101862009858e2,
        1.62138957456669019e3,
        3.29079923573345963e3,
        4.36261909014324716e3,
        3.43936767414372164e3,
        1.23033935480374942e3,
    ),
)
"""Numerator and denominator, the highest power first."""
_ONE_FROM = 6.0
"""From here on, erf is 1 to the last bit."""


def error_function(x: Floats) -> Floats:
    """Erf of each element, to about 1e-15; NaN of NaN."""
    size = np.minimum(np.abs(x), _ONE_FROM)
    near = size <= 0.5
    square = np.where(near, size * size, 0.0)
    inner = size * _ratio(_NEAR, square)
    outer = 1.0 - np.exp(-size * size) * _ratio(_FAR, size)
    found: Floats = np.copysign(np.where(near, inner, outer), x)
    return found


def _ratio(pair: tuple[Sequence[float], Sequence[float]], x: Floats) -> Floats:
    above, below = (_horner(coefficients, x) for coefficients in pair)
    ratio: Floats = above / below
    return ratio


def _horner(coefficients: Sequence[float], x: Floats) -> Floats:
    total: Floats = np.full_like(x, coefficients[0])
    for coefficient in coefficients[1:]:
        total = total * x + coefficient
    return total
