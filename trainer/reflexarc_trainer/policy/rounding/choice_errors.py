"""Running errors of what jumps: comparisons, choices by them, places of extremes.

A truth is 1 or 0, and its error 1 where float32 may say otherwise, because the numbers that are
compared lie within their errors. What is chosen by such a truth may be the other, and an element at
such a place any of its row.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from reflexarc_trainer.policy.rounding.running_error import Array, Running


def comparison(operator: Callable[[Array, Array], Any]) -> Callable[[Running, Running], Running]:
    """The rule of a comparison."""

    def rule(a: Running, b: Running) -> Running:
        reach = a.error + b.error
        is_open = (reach > 0.0) & (np.abs(a.value - b.value) <= reach)
        return _truth(operator(a.value, b.value), is_open)

    return rule


def both(a: Running, b: Running) -> Running:
    """Whether both hold: open where one is open and the other may hold."""
    is_open = (a.error > 0.0) & (b.size > 0.0) | (b.error > 0.0) & (a.size > 0.0)
    return _truth(np.minimum(a.value, b.value), is_open)


def inverse(a: Running) -> Running:
    """Whether it does not hold."""
    return _truth(1.0 - a.value, a.error > 0.0)


def either(a: Running, b: Running) -> Running:
    """Whether one of them holds."""
    return inverse(both(inverse(a), inverse(b)))


def chosen(condition: Running, a: Running, b: Running) -> Running:
    """One of two, by a truth; where that is open, off by as much as they are apart besides."""
    holds = condition.value != 0.0
    apart = np.abs(a.value - b.value) + np.maximum(a.error, b.error)
    error = np.where(condition.error > 0.0, apart, np.where(holds, a.error, b.error))
    return Running(np.where(holds, a.value, b.value), error, a.is_whole and b.is_whole)


def sign(x: Running) -> Running:
    """−1, 0 or 1."""
    is_open = (x.error > 0.0) & (np.abs(x.value) <= x.error)
    return Running(np.sign(x.value), np.where(is_open, 2.0, 0.0))


def floor(x: Running) -> Running:
    """The whole number below."""
    low, high = np.floor(x.value - x.error), np.floor(x.value + x.error)
    return Running(np.floor(x.value), np.where(low == high, 0.0, high - low))


def remainder(_: dict[str, Any], a: Running, b: Running) -> Running:
    """Of whole numbers; without bound if they are not known exactly."""
    value = np.mod(a.value, b.value)
    is_open = (a.error > 0.0) | (b.error > 0.0)
    return Running(value, np.where(is_open, np.inf, 0.0), is_whole=True)


def place_of_largest(attributes: dict[str, Any], x: Running) -> Running:
    """The place of the largest along an axis; open where another may be larger.

    Equal values of equal errors were computed alike: they are equal in float32 too.
    """
    axis, keep = attributes.get("axis", 0), bool(attributes.get("keepdims", 1))
    place = np.argmax(x.value, axis=axis, keepdims=True)
    best, reach = (np.take_along_axis(part, place, axis) for part in (x.value, x.error))
    is_alike = (x.value == best) & (x.error == reach)
    is_rival = ~is_alike & (x.value + x.error >= best - reach)
    is_open = is_rival.any(axis=axis, keepdims=True)
    found = _truth(place, is_open)
    return found if keep else found.map(lambda part: np.squeeze(part, axis))


def place_of_smallest(attributes: dict[str, Any], x: Running) -> Running:
    """The place of the smallest along an axis."""
    return place_of_largest(attributes, Running(-x.value, x.error))


def elements(attributes: dict[str, Any], x: Running, places: Running) -> Running:
    """Slices of a tensor, or elements of a row of constants, by their places."""
    axis, at = attributes.get("axis", 0), places.value.astype(np.int64)
    moved = x.map(lambda part: np.take(part, at, axis=axis))
    if not places.error.any():
        return moved
    if x.value.ndim != 1:
        return Running(moved.value, np.full_like(moved.value, np.inf))
    span = np.ptp(x.value) + x.error.max()
    return Running(moved.value, np.where(places.error > 0.0, span, moved.error), x.is_whole)


def elements_along(attributes: dict[str, Any], x: Running, places: Running) -> Running:
    """Elements of each row by their places; at an open place it may be any of its row."""
    axis, at = attributes.get("axis", 0), places.value.astype(np.int64)
    moved = x.map(lambda part: np.take_along_axis(part, at, axis))
    span = np.ptp(x.value, axis=axis, keepdims=True) + x.error.max(axis=axis, keepdims=True)
    return Running(moved.value, np.where(places.error > 0.0, span, moved.error), x.is_whole)


def _truth(holds: Any, is_open: Any) -> Running:
    return Running(np.asarray(holds, np.float64), np.where(is_open, 1.0, 0.0), is_whole=True)
