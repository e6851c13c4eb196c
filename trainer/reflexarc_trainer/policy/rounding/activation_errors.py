"""Running errors of activations: of what is bent once, and of shares by softmax.

One of a slope of at most L passes L times the error of its input on; to that comes its own.
"""

from typing import Any

import numpy as np

from reflexarc_trainer.policy.rounding.function_errors import FUNCTION_ERROR, monotone, total
from reflexarc_trainer.policy.rounding.running_error import Array, Running, divide, rounding

_ERF_SLOPE = 2.0 / np.sqrt(np.pi)


def leaky_relu(attributes: dict[str, Any], x: Running) -> Running:
    """X, or α x below 0."""
    alpha = float(attributes.get("alpha", 0.01))
    value = np.where(x.value < 0.0, alpha * x.value, x.value)
    passed = _slope_below_zero(x, abs(alpha)) * x.error
    own = np.where(x.value - x.error >= 0.0, 0.0, rounding(np.abs(value) + passed))
    return Running(value, passed + own)


def elu(attributes: dict[str, Any], x: Running) -> Running:
    """X, or α (eˣ − 1) below 0."""
    alpha = float(attributes.get("alpha", 1.0))
    bent = alpha * np.expm1(np.minimum(x.value, 0.0))
    value = np.where(x.value < 0.0, bent, x.value)
    own = np.where(x.value - x.error >= 0.0, 0.0, FUNCTION_ERROR * max(1.0, abs(alpha)))
    return Running(value, _slope_below_zero(x, abs(alpha)) * x.error + own)


def softplus(x: Running) -> Running:
    """The logarithm of 1 + eˣ."""
    return monotone(lambda y: np.logaddexp(0.0, y))(x)


def error_function(x: Running, value: Array) -> Running:
    """Erf(x), whose slope is 2/√π exp(−x²), given its values."""
    nearest = np.maximum(np.abs(x.value) - x.error, 0.0)
    slope = _ERF_SLOPE * np.exp(-np.square(nearest))
    return Running(value, np.minimum(slope * x.error, 2.0) + FUNCTION_ERROR)


def soft_max(attributes: dict[str, Any], x: Running) -> Running:
    """Shares eˣ / Σ eˣ; whichever number near the largest is taken from all, they are the same."""
    axis = int(attributes.get("axis", -1))
    away = x.value - np.max(x.value, axis=axis, keepdims=True)
    reach = x.error + np.max(x.error, axis=axis, keepdims=True)
    moved = Running(away, x.error + rounding(np.abs(away) + reach))
    powers = monotone(np.exp)(moved)
    return divide(powers, total({"axes": (axis,), "keepdims": 1}, powers))


def _slope_below_zero(x: Running, alpha: float) -> Array:
    """The steepest slope within the error of x: 1 above 0, α below."""
    below, above = x.value + x.error < 0.0, x.value - x.error >= 0.0
    return np.where(above, 1.0, np.where(below, alpha, max(1.0, alpha)))
