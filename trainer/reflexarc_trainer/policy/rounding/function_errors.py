"""Running errors of functions of one number, of extremes and of sums along an axis.

A function that only rises or only falls takes its largest error at an end of the interval in which
float32 may lie; to that comes what its own computation is off by.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import onnx

from reflexarc_trainer.policy.rounding.running_error import TINY, UNIT, Array, Running, rounding

FUNCTION_ERROR = 8 * UNIT
"""Of a function in float32, times the larger of 1 and its result: the libraries promise 4."""
_EXACT_WHOLE = 2.0**24
"""Up to here float32 has every whole number."""


def monotone(
    function: Callable[[Array], Array], low: float = -np.inf, high: float = np.inf
) -> Callable[[Running], Running]:
    """The rule of a function that only rises or only falls on [low, high].

    What rounding carries beyond its ends counts as the end: if float32 does get there, its result
    is not a number, and the parity check refuses it.
    """

    def rule(x: Running) -> Running:
        value = function(np.clip(x.value, low, high))
        ends = [function(np.clip(x.value + s * x.error, low, high)) for s in (-1.0, 1.0)]
        reach = np.maximum(*(np.abs(end - value) for end in ends))
        return Running(value, reach + FUNCTION_ERROR * np.maximum(1.0, np.abs(value)))

    return rule


def wave(function: Callable[[Array], Array]) -> Callable[[Running], Running]:
    """The rule of sine or cosine, whose slope is at most 1."""
    return lambda x: Running(function(x.value), x.error + FUNCTION_ERROR)


def power(x: Running, exponent: Running) -> Running:
    """X to a constant power; without bound below 0."""
    is_known = not exponent.error.any() and bool((exponent.value > 0.0).all())
    if not is_known or (x.value < 0.0).any():
        value = x.value**exponent.value
        return Running(value, np.full_like(value, np.inf))
    return monotone(lambda base: base**exponent.value, low=0.0)(x)


def absolute(x: Running) -> Running:
    """|x|."""
    return Running(np.abs(x.value), x.error, x.is_whole)


def negative(x: Running) -> Running:
    """−x."""
    return Running(-x.value, x.error, x.is_whole)


def larger(a: Running, b: Running) -> Running:
    """The larger of two; off by what the one is off by that is surely larger, else by the worse."""
    reach = np.maximum(a.error, b.error)
    surely_a = a.value - a.error >= b.value + b.error
    surely_b = b.value - b.error >= a.value + a.error
    error = np.where(surely_a, a.error, np.where(surely_b, b.error, reach))
    return Running(np.maximum(a.value, b.value), error, a.is_whole and b.is_whole)


def smaller(a: Running, b: Running) -> Running:
    """The smaller of two."""
    return negative(larger(negative(a), negative(b)))


def extreme(operator: Callable[..., Any]) -> Callable[[dict[str, Any], Running], Running]:
    """The rule of the largest or the smallest along axes: off by no more than the worst of them."""

    def rule(attributes: dict[str, Any], x: Running) -> Running:
        axes = _axes(attributes)
        return Running(operator(x.value, **axes), np.max(x.error, **axes), x.is_whole)

    return rule


def total(attributes: dict[str, Any], x: Running, axes: Running | None = None) -> Running:
    """The sum along axes, in whatever order."""
    if axes is not None:
        attributes = attributes | {"axes": tuple(int(axis) for axis in axes.value)}
    along = _axes(attributes)
    positive, negative = (np.sum(np.maximum(s * x.value, 0.0), **along) for s in (1.0, -1.0))
    value, error = positive - negative, np.sum(x.error, **along)
    additions = x.value.size // max(1, value.size) - 1
    size = np.maximum(positive, negative) + error
    own = np.where((size == 0.0) | x.is_whole, 0.0, rounding(size, additions))
    return Running(value, error + own, x.is_whole)


def mean(attributes: dict[str, Any], x: Running) -> Running:
    """The mean along axes: a sum, divided or multiplied by a rounded reciprocal."""
    summed = total(attributes, Running(x.value, x.error))
    count = x.value.size // max(1, summed.value.size)
    value, error = summed.value / count, summed.error / count
    operations = 2 if count > 1 else 0
    return Running(value, error + rounding(np.abs(value) + error, operations))


def cast(attributes: dict[str, Any], x: Running) -> Running:
    """To another kind of number; whether a truth holds is 0 or 1 already."""
    if attributes["to"] in (onnx.TensorProto.FLOAT, onnx.TensorProto.DOUBLE):
        large = np.where(np.abs(x.value) > _EXACT_WHOLE, UNIT * np.abs(x.value) + TINY, 0.0)
        return Running(x.value, x.error + large)
    value = np.trunc(x.value)
    is_sure = (np.trunc(x.value - x.error) == value) & (np.trunc(x.value + x.error) == value)
    return Running(value, np.where(is_sure, 0.0, x.error + 1.0), is_whole=True)


def _axes(attributes: dict[str, Any]) -> dict[str, Any]:
    axes = attributes.get("axes")
    keep = bool(attributes.get("keepdims", 1))
    return {"axis": None if not axes else tuple(int(a) for a in axes), "keepdims": keep}
