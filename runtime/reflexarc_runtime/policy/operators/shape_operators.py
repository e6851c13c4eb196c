"""ONNX operators of shape: the same elements in other places, and arrays made from a shape.

Axes and sizes were attributes in earlier versions of the operator set, and are inputs since.
"""

import math

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.graph_node import (
    Maker,
    OnnxNode,
    Operator,
    Tensor,
    array_of,
    plain,
)

_NO_ENDS = (2**31 - 1, 2**63 - 1)
"""What ONNX takes for the far end, in either direction."""


def _constant(node: OnnxNode) -> Operator:
    (name,) = node.attributes or ("value",)
    value = node[name]
    if name == "value":
        array = array_of(value)
    elif name in ("value_float", "value_floats"):
        array = np.array(value, np.float64)
    elif name in ("value_int", "value_ints"):
        array = np.array(value, np.int64)
    else:
        raise PolicyError(f"operator Constant: {name} is not in the NumPy backend, only numbers")
    return lambda: array


def _constant_of_shape(node: OnnxNode) -> Operator:
    given = node.get("value")
    value = np.zeros(1) if given is None else array_of(given)
    return lambda shape: np.full(_ints(shape), value.reshape(-1)[0], value.dtype)


def _range(start: Tensor, limit: Tensor, delta: Tensor) -> Tensor:
    first, last, step = (array.reshape(-1)[0] for array in (start, limit, delta))
    count = max(0, math.ceil((last - first) / step))
    result: Tensor = np.add(first, np.arange(count).astype(start.dtype) * step)
    return result


def _shape(node: OnnxNode) -> Operator:
    start, end = node.get("start", 0), node.get("end")
    return lambda x: np.array(x.shape[slice(start, end)], np.int64)


def _flatten(node: OnnxNode) -> Operator:
    axis = node.get("axis", 1)
    return lambda x: x.reshape(math.prod(x.shape[:axis]), math.prod(x.shape[axis:]))


def _reshape(node: OnnxNode) -> Operator:
    node.require("allowzero", 0, "a 0 must keep the size that is there")

    def reshape(x: Tensor, shape: Tensor) -> Tensor:
        kept = [x.shape[i] if size == 0 else int(size) for i, size in enumerate(shape)]
        return x.reshape(kept)

    return reshape


def _concat(node: OnnxNode) -> Operator:
    axis = node["axis"]
    return lambda *parts: np.concatenate(parts, axis)


def _transpose(node: OnnxNode) -> Operator:
    axes = node.get("perm")
    return lambda x: np.transpose(x, axes)


def _slice(node: OnnxNode) -> Operator:
    always = {name: node.get(name) for name in ("starts", "ends", "axes")}

    def cut(
        x: Tensor,
        starts: Tensor | None = always["starts"],
        ends: Tensor | None = always["ends"],
        axes: Tensor | None = always["axes"],
        steps: Tensor | None = None,
    ) -> Tensor:
        if starts is None or ends is None:
            raise PolicyError("operator Slice: expected starts and ends, got none")
        axes = np.arange(len(starts)) if axes is None else axes
        steps = np.ones(len(starts), np.int64) if steps is None else steps
        picked = [slice(None)] * x.ndim
        for axis, start, end, step in zip(axes, starts, ends, steps, strict=True):
            picked[axis] = _cut(int(start), int(end), int(step), x.shape[axis])
        return x[tuple(picked)]

    return cut


def _cut(start: int, end: int, step: int, size: int) -> slice:
    """Negative ends count from the end; beyond an end means up to it, the largest number too."""
    if step > 0:
        return slice(start, end, step)
    if step == 0:
        raise PolicyError("operator Slice: expected another step than 0")
    first = min(max(start + size if start < 0 else start, 0), size - 1)
    last = -1 if end in _NO_ENDS else min(end + size if end < 0 else end, size - 1)
    return slice(first, last if last >= 0 else None, step)


def _squeeze(node: OnnxNode) -> Operator:
    always = node.get("axes")

    def squeeze(x: Tensor, axes: Tensor | None = always) -> Tensor:
        return np.squeeze(x, None if axes is None else _ints(axes))

    return squeeze


def _unsqueeze(node: OnnxNode) -> Operator:
    always = node.get("axes", ())
    return lambda x, axes=always: np.expand_dims(x, _ints(axes))


def _expand(x: Tensor, shape: Tensor) -> Tensor:
    return np.broadcast_to(x, np.broadcast_shapes(x.shape, _ints(shape)))


def _tile(x: Tensor, repeats: Tensor) -> Tensor:
    return np.tile(x, _ints(repeats))


def _pad(node: OnnxNode) -> Operator:
    mode = node.word("mode", "constant")
    if mode not in ("constant", "edge", "reflect", "wrap"):
        raise PolicyError(f"operator Pad: mode={mode} is not known")
    always, filler = node.get("pads"), np.array(node.get("value", 0.0))

    def pad(
        x: Tensor,
        pads: Tensor | None = always,
        value: Tensor | None = filler,
        axes: Tensor | None = None,
    ) -> Tensor:
        widths = _widths(x.ndim, () if pads is None else _ints(pads), axes)
        # A negative width cuts off.
        kept = tuple(
            slice(max(-a, 0), size - max(-b, 0))
            for (a, b), size in zip(widths, x.shape, strict=True)
        )
        added = [(max(a, 0), max(b, 0)) for a, b in widths]
        if mode != "constant":
            return np.pad(x[kept], added, mode)  # type: ignore[call-overload, no-any-return]  # checked above
        fill = 0 if value is None else value.reshape(-1)[0]
        return np.pad(x[kept], added, constant_values=fill)

    return pad


def _widths(rank: int, pads: tuple[int, ...], axes: Tensor | None) -> list[tuple[int, int]]:
    """How much is added before and behind each axis."""
    widths = [(0, 0)] * rank
    named = range(rank) if axes is None else _ints(axes)
    half = len(pads) // 2
    for axis, before, behind in zip(named, pads[:half], pads[half:], strict=True):
        widths[axis] = (before, behind)
    return widths


def _split(node: OnnxNode) -> Operator:
    axis, count = node.get("axis", 0), len(node.outputs)
    node.require("num_outputs", count, f"it has {count} outputs")
    always = node.get("split")

    def split(x: Tensor, sizes: Tensor | None = always) -> tuple[Tensor, ...]:
        if sizes is None:
            # Parts of equal size, the last one smaller if need be.
            sizes = np.full(count, -(-x.shape[axis] // count))
        return tuple(np.split(x, np.cumsum(sizes)[:-1], axis))

    return split


def _triangle(node: OnnxNode) -> Operator:
    cut = np.triu if node.get("upper", 1) else np.tril
    return lambda x, k=None: cut(x, 0 if k is None else int(k.reshape(-1)[0]))


def _ints(numbers: Tensor) -> tuple[int, ...]:
    return tuple(int(number) for number in numbers)


SHAPING: dict[str, Maker] = {
    "Concat": _concat,
    "Constant": _constant,
    "ConstantOfShape": _constant_of_shape,
    "Expand": plain(_expand),
    "Flatten": _flatten,
    "Pad": _pad,
    "Range": plain(_range),
    "Reshape": _reshape,
    "Shape": _shape,
    "Size": plain(lambda x: np.array(x.size, np.int64)),
    "Slice": _slice,
    "Split": _split,
    "Squeeze": _squeeze,
    "Tile": plain(_tile),
    "Transpose": _transpose,
    "Trilu": _triangle,
    "Unsqueeze": _unsqueeze,
}
"""Name of an ONNX operator → what makes its function from a node."""
