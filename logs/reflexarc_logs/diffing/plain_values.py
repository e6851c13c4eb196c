"""Nested dictionaries and lists of plain values, and where two of them differ."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

Value: TypeAlias = Any
"""A dictionary, a list, or a plain value."""
Differing: TypeAlias = tuple[str, Any, Any]
"""A path, as `command.linear_mps` or `q_values[1]`, and both values."""

ABSENT = "absent"
"""Stands for the value of the side that has none."""


def leaves(value: Value, path: str = "") -> Iterator[tuple[str, Any]]:
    """Each plain value with its path; an empty list or dictionary is one, too."""
    if isinstance(value, Mapping) and value:
        for name, inner in value.items():
            yield from leaves(inner, f"{path}.{name}" if path else str(name))
    elif isinstance(value, list) and value:
        for index, inner in enumerate(value):
            yield from leaves(inner, f"{path}[{index}]")
    elif path or not isinstance(value, Mapping | list):
        yield path, value


def differing(a: Value, b: Value, path: str = "") -> Iterator[Differing]:
    """Where two values are not the same: in A's order, then what only B has."""
    ours, theirs = dict(leaves(a, path)), dict(leaves(b, path))
    for where in (*ours, *(p for p in theirs if p not in ours)):
        x, y = ours.get(where, ABSENT), theirs.get(where, ABSENT)
        if not is_same(x, y):
            yield where, x, y


def is_same(a: Any, b: Any) -> bool:
    """Equal, and of one kind: 1 is not true, 0.0 is not -0.0, but one NaN is another."""
    if isinstance(a, float) and isinstance(b, float):
        return (a == b and math.copysign(1, a) == math.copysign(1, b)) or (a != a and b != b)
    return isinstance(a, bool) == isinstance(b, bool) and bool(a == b)
