"""What a unit computes from its weighted sum, and its slope; compiled.

σ(x) = 1 / (1 + e⁻ˣ),   tanh x = 2 σ(2x) − 1,   relu(x) = max(0, x).

The exponential is ours, for the library's is a call that keeps a loop from becoming vector
instructions: x = k ln 2 + r, then a polynomial in r, and k put straight into the exponent's bits.
Its relative error is below 4e-16 (the tests hold it).
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_trainer.fused import fused, fused_inline

LINEAR, SIGMOID, TANH, RELU = range(4)
UNITS = {"linear": LINEAR, "sigmoid": SIGMOID, "tanh": TANH, "relu": RELU}
"""Code of each kind of unit."""

_LOG2_E = 1.4426950408889634
# ln 2 in two parts, the first with so few bits that k times it is exact (fdlibm's e_exp.c).
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_LEAST = -708.0
"""Below it e to the x would leave the normal numbers."""
_C2, _C3, _C4, _C5, _C6, _C7 = 1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 720, 1 / 5040
_C8, _C9, _C10, _C11 = 1 / 40320, 1 / 362880, 1 / 3628800, 1 / 39916800
_C12, _C13 = 1 / 479001600, 1 / 6227020800


def _bitcast(_: Any, bits: Any) -> Any:
    """The float64 that a 64-bit pattern stands for."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(types.float64))

    return types.float64(types.int64), emit


_float_of_bits: Any = intrinsic(_bitcast)  # its stub says that a call returns nothing


@fused_inline
def exp_of_negative(x: float) -> float:
    """Exponential function of x ≤ 0."""
    x = max(x, _LEAST)
    k = np.rint(x * _LOG2_E)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    r2 = r * r
    r4 = r2 * r2
    # In pairs, and pairs of pairs: a chain of thirteen would wait for itself.
    low = ((1.0 + r) + r2 * (_C2 + r * _C3)) + r4 * ((_C4 + r * _C5) + r2 * (_C6 + r * _C7))
    high = ((_C8 + r * _C9) + r2 * (_C10 + r * _C11)) + r4 * (_C12 + r * _C13)
    power: float = _float_of_bits((np.int64(k) + 1023) << 52)
    result: float = (low + r4 * r4 * high) * power
    return result


@fused_inline
def sigmoid(x: float) -> float:
    """σ(x), without overflow for any x."""
    tail = exp_of_negative(-abs(x))
    return (1.0 if x >= 0.0 else tail) / (1.0 + tail)


@fused_inline
def tanh(x: float) -> float:
    """The hyperbolic tangent, without overflow for any x, to 2e-16 absolutely."""
    tail = exp_of_negative(-2.0 * abs(x))
    size = (1.0 - tail) / (1.0 + tail)
    return size if x >= 0.0 else -size


@fused
def activate(units: int, values: npt.NDArray[np.floating]) -> None:
    """Weighted sums become activations, in place: (n,)."""
    zero = values.dtype.type(0)
    if units == SIGMOID:
        for k in range(len(values)):
            values[k] = sigmoid(values[k])
    elif units == TANH:
        for k in range(len(values)):
            values[k] = tanh(values[k])
    elif units == RELU:
        for k in range(len(values)):
            # Written so that NaN stays NaN.
            values[k] = zero if values[k] < zero else values[k]


@fused
def times_slope(
    units: int, activations: npt.NDArray[np.floating], back: npt.NDArray[np.floating]
) -> None:
    """Gradients by activations become gradients by weighted sums, in place: (n,) each."""
    zero, one = back.dtype.type(0), back.dtype.type(1)
    if units == SIGMOID:
        for k in range(len(back)):
            back[k] *= activations[k] * (one - activations[k])
    elif units == TANH:
        for k in range(len(back)):
            back[k] *= one - activations[k] * activations[k]
    elif units == RELU:
        for k in range(len(back)):
            back[k] = back[k] if activations[k] > zero else zero
