"""One node with its inputs, and what the arrays of trials are drawn from."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from support.onnx_nodes import Array

sides = st.integers(1, 4)


@dataclass
class Trial:
    """What a node is given, and what it says."""

    inputs: list[Array | None]
    attributes: dict[str, Any] = field(default_factory=dict)
    outputs: int = 1
    opset: int = 17
    tolerance: float = 2e-6


class Draw:
    """Draws arrays and numbers for one trial."""

    def __init__(self, data: st.DataObject) -> None:
        self.one = data.draw

    def of(self, *values: Any) -> Any:
        """One of these."""
        return self.one(st.sampled_from(values))

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends included."""
        return self.one(st.integers(low, high))

    def shape(self, least: int = 1, most: int = 4) -> list[int]:
        """The sides of an array of so many axes."""
        return self.one(st.lists(sides, min_size=least, max_size=most))

    def floats(self, shape: Any, low: float = -9.0, high: float = 9.0) -> Array:
        """Numbers from low to high, both ends more often."""
        bounds = float(np.float32(low)), float(np.float32(high))
        element = st.floats(*bounds, width=32) | st.sampled_from(bounds)
        return self.one(arrays.arrays(np.float32, tuple(shape), elements=element))

    def coarse(self, shape: Any) -> Array:
        """Numbers of which many are equal."""
        some = st.sampled_from([-1.5, -0.0, 0.0, 0.5, 2.0])
        return self.one(arrays.arrays(np.float32, tuple(shape), elements=some))

    def normal(self, *shape: int) -> Array:
        """Normally distributed numbers, as weights are."""
        seed = self.whole(0, 999)
        return np.random.default_rng(seed).normal(size=shape).astype(np.float32)

    def truths(self, shape: Any) -> Array:
        """True and false."""
        return self.one(arrays.arrays(np.bool_, tuple(shape)))

    def ints(self, shape: Any, low: int, high: int, dtype: Any = np.int64) -> Array:
        """Whole numbers from low to high."""
        element = st.integers(low, high)
        return self.one(arrays.arrays(dtype, tuple(shape), elements=element))

    def axis(self, shape: Any) -> int:
        """One axis of a shape, counted from either end."""
        return self.whole(-len(shape), len(shape) - 1)

    def axes(self, shape: Any, least: int = 0) -> list[int]:
        """Some axes of a shape, each at most once, counted from either end."""
        ends = st.integers(-len(shape), len(shape) - 1)
        unique = st.lists(ends, min_size=least, unique_by=lambda axis: axis % len(shape))
        return self.one(unique)

    def narrower(self, shape: list[int]) -> list[int]:
        """A shape that broadcasts to another."""
        kept = [self.of(1, side) for side in shape]
        return kept[self.whole(0, len(kept) - 1) :]


Drawn: TypeAlias = Callable[[Draw], Trial]


def filled(shape: Any) -> Array:
    """Each element another number."""
    return np.arange(np.prod(shape), dtype=np.float32).reshape(shape)


def ints(*numbers: int) -> Array:
    """Whole numbers, as an input that says axes, sizes or places."""
    return np.array(numbers, np.int64)
