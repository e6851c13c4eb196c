"""What a graph may take in the NumPy backend: memory and work are bounded before they are spent.

A file of a few kilobytes can ask for gigabytes: an outer product, a shape in a constant, a
thousandfold repetition. Each node's part is estimated from the shapes of its inputs, and from the
values where they say a shape, just before it would be computed.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.activation_operators import ACTIVATIONS
from reflexarc_runtime.policy.operators.elementwise_operators import ELEMENTWISE
from reflexarc_runtime.policy.operators.graph_node import OnnxNode, Tensor
from reflexarc_runtime.policy.operators.reducing_operators import REDUCING
from reflexarc_runtime.policy.operators.shape_operators import SHAPING
from reflexarc_runtime.policy.operators.window_operators import window_of

ELEMENTS_OF_ONE = 1 << 23
"""Numbers that one decision may make, 64 MiB of float64; the exporter's networks make thousands."""
ELEMENTS_AT_ONCE = 1 << 24
"""Those of a batch; a larger one is computed in parts."""
OPERATIONS_OF_ONE = 1 << 30
"""Multiplications that one decision may take: about a second."""
_WEIGHT = 8
"""A number that is made or read by itself costs about as much as so many in a matrix product."""
_STEP_OPERATIONS = 20_000
"""What one step of a recurrent network costs besides."""

Inputs: TypeAlias = Sequence[Any]
Cost: TypeAlias = Callable[[OnnxNode, Inputs], tuple[int, int]]
"""From a node and its inputs: numbers made at once, temporary ones too, and multiplications."""

_ALL, _BUT_THE_FIRST = slice(0, None), slice(1, None)
SHAPE_INPUTS: dict[str, slice] = {
    **dict.fromkeys(REDUCING, _BUT_THE_FIRST),
    **dict.fromkeys(SHAPING, _BUT_THE_FIRST),
    "Concat": slice(0, 0),
    "ConstantOfShape": _ALL,
    "OneHot": slice(1, 2),
    "Range": _ALL,
}
"""Which inputs of an operator say a shape by their values."""


class Meter:
    """Adds up what a decision takes, and refuses what is too much.

    Args:
        elements: how many numbers may be made.
        rows: for how many decisions at once.
    """

    def __init__(self, elements: int, rows: int) -> None:
        self.made = 0
        self._elements = elements
        self._operations_left = OPERATIONS_OF_ONE * max(1, rows)

    def count(self, node: OnnxNode, inputs: Inputs) -> None:
        """Count what a node is about to take.

        Raises:
            PolicyError: it is too much.
        """
        elements, operations = COSTS.get(node.kind, _of_inputs)(node, inputs)
        read = sum(x.size for x in inputs if isinstance(x, np.ndarray))
        self.made += elements
        self._operations_left -= operations + _WEIGHT * (elements + read)
        if self.made > self._elements:
            raise PolicyError(
                f"node {node.name[:60]!r} ({node.kind}) brings its decision to "
                f"{8 * self.made / 2**20:.4g} MiB, more than {8 * self._elements >> 20} MiB"
            )
        if self._operations_left < 0:
            raise PolicyError(
                f"node {node.name[:60]!r} ({node.kind}) brings its decision to more than "
                f"{OPERATIONS_OF_ONE} multiplications"
            )


def _of_inputs(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    """No more than what comes in: moves, sums and places."""
    return sum(_size(x) for x in inputs), 0


def _broadcast(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    return math.prod(_joint([x.shape for x in inputs if x is not None])), 0


def _broadcast_often(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    """With a few arrays on the way."""
    return 4 * _broadcast(node, inputs)[0], 0


def _joint(shapes: Iterable[Sequence[int]]) -> list[int]:
    """The shape that arrays are broadcast to; whether they can be is for NumPy to say."""
    joint: list[int] = []
    for shape in shapes:
        joint = [1] * (len(shape) - len(joint)) + joint
        for axis in range(1, len(shape) + 1):
            pair = joint[-axis], shape[-axis]
            joint[-axis] = max(pair) if all(pair) else 0
    return joint


def _by_channel(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    """Numbers of each channel, which must be as many as there are channels."""
    x, *others = inputs
    channels = x.shape[1] if x.ndim > 1 else 1
    fit = all(other.size in (1, channels) for other in others if other is not None)
    return 3 * x.size * (1 if fit else max(_size(other) for other in others)), 0


def _filled(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    return _product(inputs[0]), 0


def _expanded(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    return math.prod(_joint([inputs[0].shape, _ints(inputs[1])])), 0


def _tiled(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    return 2 * inputs[0].size * max(1, _product(inputs[1])), 0


def _padded(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    pads = node.get("pads", ()) if len(inputs) < 2 or inputs[1] is None else _ints(inputs[1])
    added = [max(0, int(width)) for width in pads]
    half = len(added) // 2
    rank = inputs[0].ndim
    if half == rank:
        sides = zip(inputs[0].shape, added[:half], added[half:], strict=False)
        return 2 * math.prod(size + before + behind for size, before, behind in sides), 0
    # Some axes, named by another input: as if each were padded by the most.
    most = sum(sorted(added)[-2:])
    return 2 * math.prod(size + most for size in inputs[0].shape), 0


def _counted(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    start, limit, step = (float(x.reshape(-1)[0]) for x in inputs)
    count = (limit - start) / step + 1 if step else math.inf
    return int(min(max(2 * count, 0.0), 2.0**62)) if count == count else 0, 0


def _gathered(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    x, places = inputs[:2]
    axis = node.get("axis", 0)
    side = x.shape[axis] if -x.ndim <= axis < x.ndim else 1
    return places.size * (x.size // max(1, side)), 0


def _gathered_parts(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    x, places = inputs[:2]
    depth = places.shape[-1] if places.ndim else 1
    return places.size + places.size // max(1, depth) * math.prod(x.shape[depth:]), 0


def _one_hot(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    return 2 * inputs[0].size * max(1, int(inputs[1].reshape(-1)[0])), 0


def _product_of_two(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    a, b = (x.shape if x.ndim > 1 else (1, x.size) for x in inputs[:2])
    b = b if inputs[1].ndim > 1 else b[::-1]
    elements = math.prod(_joint([a[:-2], b[:-2]])) * a[-2] * b[-1]
    return elements, elements * a[-1]


def _gemm(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    a, b = inputs[0].shape, inputs[1].shape
    rows, inner = a[::-1] if node.get("transA", 0) else a
    columns = b[0] if node.get("transB", 0) else b[-1]
    third = [inputs[2].shape] if len(inputs) > 2 and inputs[2] is not None else []
    return 2 * math.prod(_joint([(rows, columns), *third])), rows * columns * inner


def _einsum(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    """Every combination of indices is one multiplication, and at worst one element."""
    equation = node.word("equation", "").replace(" ", "")
    before, _, after = equation.partition("->")
    sides: dict[str, int] = {}
    for term, x in zip(before.split(","), inputs, strict=False):
        if "." in term or len(term) != x.ndim:
            return math.prod(max(1, x.size) for x in inputs), 0
        for letter, side in zip(term, x.shape, strict=True):
            sides[letter] = max(side, sides.get(letter, 1))
    every = math.prod(sides.values())
    made = math.prod(sides.get(letter, 1) for letter in after) if "->" in equation else every
    return made, _WEIGHT * every


def _window(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    """The padded input, and for a convolution every window side by side."""
    x = inputs[0]
    is_conv = node.kind == "Conv"
    kernel = inputs[1].shape[2:] if is_conv else tuple(node["kernel_shape"])
    window = window_of(node, kernel)
    around = zip(x.shape[2:], window.around(x.shape[2:]), window.strides, strict=True)
    padded = math.prod(x.shape[:2]) * math.prod(
        size + before + behind + window.is_ceil * stride
        for size, (before, behind), stride in around
    )
    places = math.prod(window.positions(x.shape[2:]))
    seen = math.prod(x.shape[:2]) * places * math.prod(kernel)
    if not is_conv:
        return padded + math.prod(x.shape[:2]) * places, _WEIGHT * seen
    outputs, per_output = inputs[1].shape[0], math.prod(inputs[1].shape[1:])
    made = x.shape[0] * places * outputs
    return padded + seen + 2 * made, made * per_output


def _recurrent(node: OnnxNode, inputs: Inputs) -> tuple[int, int]:
    steps, n = inputs[0].shape[:2]
    rows, size = inputs[2].shape[1:]
    made = steps * n * (2 * rows + 2 * size)
    inner = inputs[0].shape[2] + size
    return made, steps * (n * rows * inner + _STEP_OPERATIONS)


def _size(x: Any) -> int:
    return int(x.size) if isinstance(x, np.ndarray) else 0


def _product(sides: Tensor) -> int:
    return math.prod(max(0, side) for side in _ints(sides))


def _ints(numbers: Tensor) -> list[int]:
    return [int(number) for number in numbers.reshape(-1)]


COSTS: dict[str, Cost] = {
    **dict.fromkeys(ELEMENTWISE, _broadcast),
    **dict.fromkeys((*ACTIVATIONS, "Erf", "Div", "Pow"), _broadcast_often),
    "AveragePool": _window,
    "BatchNormalization": _by_channel,
    "Constant": lambda node, inputs: (0, 0),
    "ConstantOfShape": _filled,
    "Conv": _window,
    "Einsum": _einsum,
    "Expand": _expanded,
    "GRU": _recurrent,
    "Gather": _gathered,
    "GatherElements": _of_inputs,
    "GatherND": _gathered_parts,
    "Gemm": _gemm,
    "GroupNormalization": _by_channel,
    "InstanceNormalization": _by_channel,
    "LSTM": _recurrent,
    "LayerNormalization": _broadcast,
    "MatMul": _product_of_two,
    "MaxPool": _window,
    "OneHot": _one_hot,
    "Pad": _padded,
    "RMSNormalization": _broadcast,
    "RNN": _recurrent,
    "Range": _counted,
    "Shape": lambda node, inputs: (inputs[0].ndim, 0),
    "Size": lambda node, inputs: (1, 0),
    "Tile": _tiled,
    "TopK": lambda node, inputs: (5 * inputs[0].size, 0),
}
"""Where it is not what comes in."""
