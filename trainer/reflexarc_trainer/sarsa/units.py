"""Activation functions of units and their slopes; compiled.

    σ(x) = 1 / (1 + e⁻ˣ)                            σ′ = σ (1 − σ)
    tanh x = (1 − e⁻²ˣ) / (1 + e⁻²ˣ)                tanh′ = 1 − tanh²
    relu(x) = max(0, x)                             relu′ = 1 where x > 0, else 0

σ and tanh are computed from e to the −|x|, which cannot overflow.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused, fused_inline
from reflexarc_trainer.sarsa.exponential import exp_of_negative

LINEAR, SIGMOID, TANH, RELU = range(4)
UNITS = {"linear": LINEAR, "sigmoid": SIGMOID, "tanh": TANH, "relu": RELU}
"""Code of each kind of unit."""

_ZERO, _ONE, _TWO = np.float32(0.0), np.float32(1.0), np.float32(2.0)
"""float32, so that arithmetic with float32 stays in float32, and with float64 in float64."""


@fused
def activate(units: int, values: npt.NDArray[np.floating]) -> None:
    """Replace weighted sums by activations, in place.

    Args:
        units: kind of the units.
        values: (n,).
    """
    number = values.dtype.type
    if units == SIGMOID:
        for k in range(len(values)):
            x = values[k]
            values[k] = sigmoid(x, number(exp_of_negative(-abs(x))))
    elif units == TANH:
        for k in range(len(values)):
            x = values[k]
            values[k] = tanh(x, number(exp_of_negative(-_TWO * abs(x))))
    elif units == RELU:
        for k in range(len(values)):
            # Written so that NaN stays NaN.
            values[k] = _ZERO if values[k] < _ZERO else values[k]


@fused_inline
def sigmoid(x: Any, tail: Any) -> Any:
    """σ(x), without overflow for any x; `tail` is e to the −|x|."""
    return (_ONE if x >= _ZERO else tail) / (_ONE + tail)


@fused_inline
def tanh(x: Any, tail: Any) -> Any:
    """The hyperbolic tangent, without overflow for any x; `tail` is e to the −2|x|."""
    size = (_ONE - tail) / (_ONE + tail)
    return size if x >= _ZERO else -size


@fused
def times_slope(
    units: int, activations: npt.NDArray[np.floating], back: npt.NDArray[np.floating]
) -> None:
    """Replace gradients by activations by those by weighted sums, in place: multiply by the slopes.

    Args:
        units: kind of the units.
        activations: (n,).
        back: the gradients: (n,).
    """
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
