"""Running errors of what slides along rays or images, and of the product of two tensors.

A convolution is a sum as that of a layer is (`running_error.affine`); its parts are computed by the
reference's own convolution, of absolute values.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from reflexarc_trainer.policy.rounding.running_error import UNIT, Array, Running, rounding


def convolution(
    operator: Callable[..., Any],
    _: dict[str, Any],
    x: Running,
    w: Running,
    b: Running | None = None,
) -> Running:
    """A convolution with constant weights."""
    if w.error.any() or (b is not None and b.error.any()):
        value = operator(x.value, w.value, *(() if b is None else (b.value,)))
        return Running(value, np.full_like(value, np.inf))
    up, down = np.maximum(w.value, 0.0), np.maximum(-w.value, 0.0)
    above, below = np.maximum(x.value, 0.0), np.maximum(-x.value, 0.0)
    shift = np.zeros(len(w.value)) if b is None else b.value
    positive = operator(above, up, np.maximum(shift, 0.0)) + operator(below, down)
    negative = operator(below, up, np.maximum(-shift, 0.0)) + operator(above, down)
    gains = up + down
    error = operator(x.error, gains) + UNIT * operator(x.size, gains)
    terms = math.prod(w.value.shape[1:]) + (b is not None)
    error = error + rounding(np.maximum(positive, negative) + error, terms - 1)
    return Running(positive - negative, error)


def largest(operator: Callable[..., Any], _: dict[str, Any], x: Running) -> Running:
    """The largest of a window: off by no more than the worst of it."""
    return Running(operator(x.value), operator(x.error), x.is_whole)


def mean(operator: Callable[..., Any], attributes: dict[str, Any], x: Running) -> Running:
    """The mean of a window: a sum, divided or multiplied by a rounded reciprocal."""
    positive, negative = (operator(np.maximum(s * x.value, 0.0)) for s in (1.0, -1.0))
    error = operator(x.error)
    operations = math.prod(attributes["kernel_shape"]) + 1
    error = error + rounding(np.maximum(positive, negative) + error, operations)
    return Running(positive - negative, error)


def product(a: Running, b: Running) -> Running:
    """A matrix product of two tensors that were both computed: |âb̂ − ab| ≤ |a| e_b + |b̂| e_a."""
    error = np.abs(a.value) @ b.error + a.error @ b.size
    size: Array = a.size @ b.size
    return Running(a.value @ b.value, error + rounding(size, a.value.shape[-1]))
