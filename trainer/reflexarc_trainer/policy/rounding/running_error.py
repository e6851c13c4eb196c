"""Arithmetic that carries a bound of what float32 gets wrong (running error analysis).

A `Running` value is exact up to float64; its `error` bounds, element by element, how far the same
computation in float32 may lie from it. Each operation passes the errors of its inputs on and adds
its own. Source: Higham, Accuracy and Stability of Numerical Algorithms (2002), sections 3.3, 4.2.

One operation is off by at most u |result|, u = 2⁻²⁴, and by nothing where float32 has the result.
A sum of n terms is, in any order, with fused multiplication or without, a tree of n − 1 additions;
each is off by u times a sum of some of the terms, which lies between N, the sum of the negative
ones, and P, that of the positive ones. So the additions are off by (n − 1) u max(P, |N|) together:
half of the usual γₙ Σ|wᵢxᵢ| where the signs are mixed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.policy.operators.activation_operators import sigmoid as exact_sigmoid

Array: TypeAlias = npt.NDArray[np.float64]

UNIT = 2.0**-24
"""u: relative error of one operation in float32."""
TINY = 2.0**-126
"""What a result near 0 may be off by besides: float32 may keep no digits below it."""
LARGEST = float(np.finfo(np.float32).max)
SIGMOID_ERROR = 6 * UNIT
"""Of onnxruntime's sigmoid, a quotient of polynomials: twice the largest of 22 million values."""
TANH_ERROR = 11 * UNIT
"""The same of its tanh."""


@dataclass(frozen=True)
class Running:
    """Values, and what float32 may be off by; two arrays of one shape."""

    value: Array
    error: Array
    is_whole: bool = False
    """Of integers, with which any backend computes exactly."""

    @property
    def size(self) -> Array:
        """The largest absolute value that float32 may have for it."""
        size: Array = np.abs(self.value) + self.error
        return size

    def map(self, move: Callable[[Array], Array]) -> "Running":
        """The same with its elements moved."""
        return Running(move(self.value), move(self.error), self.is_whole)


def exactly(values: npt.NDArray[np.generic]) -> Running:
    """Values that float32 has without error."""
    known = values.astype(np.float64)
    return Running(known, np.zeros_like(known), is_whole=values.dtype.kind in "iub")


def rounding(size: Array, operations: int = 1) -> Array:
    """What so many operations with results of a size are off by; infinite where float32 ends."""
    own = operations * UNIT * size / (1.0 - operations * UNIT) + operations * TINY
    return np.where(size > LARGEST, np.inf, own)


def add(a: Running, b: Running) -> Running:
    """Add."""
    return _rounded(a.value + b.value, a.error + b.error, a.is_whole and b.is_whole)


def subtract(a: Running, b: Running) -> Running:
    """Subtract."""
    return _rounded(a.value - b.value, a.error + b.error, a.is_whole and b.is_whole)


def multiply(a: Running, b: Running) -> Running:
    """Multiply: |âb̂ − ab| ≤ |a| e_b + |b̂| e_a."""
    error = np.abs(a.value) * b.error + b.size * a.error
    return _rounded(a.value * b.value, error, a.is_whole and b.is_whole)


def divide(a: Running, b: Running) -> Running:
    """Divide: |â/b̂ − a/b| ≤ (e_a + |a/b| e_b) / |b̂|; without bound if b̂ may be 0."""
    ratio, nearest = a.value / b.value, np.abs(b.value) - b.error
    error = (a.error + np.abs(ratio) * b.error) / nearest
    return _rounded(ratio, np.where(nearest > 0.0, error, np.inf))


def square_root(x: Running) -> Running:
    """√x, of what is not below 0; what is so by rounding has no root, and the parity check sees."""
    low, value, high = (np.sqrt(np.maximum(x.value + s * x.error, 0.0)) for s in (-1.0, 0.0, 1.0))
    return _rounded(value, np.maximum(high - value, value - low))


def relu(x: Running) -> Running:
    """The larger of 0 and x; whatever is below 0 in float32 too becomes 0 without error."""
    return Running(np.maximum(x.value, 0.0), np.where(x.value < -x.error, 0.0, x.error))


def sigmoid(x: Running) -> Running:
    """σ(x), whose slope is σ(1 − σ)."""
    steepest = exact_sigmoid(_nearest_to_zero(x))
    error = steepest * (1.0 - steepest) * x.error + SIGMOID_ERROR
    return Running(exact_sigmoid(x.value), error)


def tanh(x: Running) -> Running:
    """Tanh(x), whose slope is 1 − tanh²."""
    steepest = np.tanh(_nearest_to_zero(x))
    return Running(np.tanh(x.value), (1.0 - steepest**2) * x.error + TANH_ERROR)


def affine(x: Running, weights: Array, *biases: Array) -> Running:
    """X W + Σ b, summed in whatever order.

    Args:
        x: (…, inputs).
        weights: (inputs, outputs).
        biases: each (outputs,).
    """
    zero = np.zeros(())
    up, down = np.maximum(weights, 0.0), np.maximum(-weights, 0.0)
    above, below = np.maximum(x.value, 0.0), np.maximum(-x.value, 0.0)
    positive = above @ up + below @ down + sum((np.maximum(b, 0.0) for b in biases), zero)
    negative = below @ up + above @ down + sum((np.maximum(-b, 0.0) for b in biases), zero)
    gains = up + down
    error = x.error @ gains + UNIT * (x.size @ gains)
    additions = max(len(weights) + len(biases) - 1, 0)
    error = error + rounding(np.maximum(positive, negative) + error, additions)
    return Running(positive - negative, error)


def side_by_side(*parts: Running) -> Running:
    """Joined along the last axis."""
    return Running(
        np.concatenate([part.value for part in parts], axis=-1),
        np.concatenate([part.error for part in parts], axis=-1),
    )


def _rounded(value: Array, error: Array, is_whole: bool = False) -> Running:
    """One operation more; an exact result that float32 has, from exact inputs, is what it gets."""
    with np.errstate(over="ignore"):
        is_exact = (error == 0.0) & (value.astype(np.float32) == value)
    own = np.where(is_whole | is_exact, 0.0, rounding(np.abs(value) + error))
    return Running(value, error + own, is_whole)


def _nearest_to_zero(x: Running) -> Array:
    """Of what each unit is given, by any of the inputs, the value nearest to 0: the steepest one.

    Not that of each input by itself: a unit with large weights is steep for few inputs only, and
    another input than those tried may be among them.
    """
    inputs = tuple(range(x.value.ndim - 1))
    low = np.min(x.value - x.error, axis=inputs, keepdims=True)
    high = np.max(x.value + x.error, axis=inputs, keepdims=True)
    return np.clip(np.zeros(()), low, high)
