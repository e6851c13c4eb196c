"""NumPy's functions of whole arrays as ONNX nodes: along axes, of shapes, of places.

Axis 0 is the batch, of which the example has one. An array of constants stands for every agent.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from reflexarc_baselines.exporting.element_rules import example_of
from reflexarc_baselines.exporting.graph_tensor import GraphScribe, GraphTensor, Rule, refuse


def for_every_agent(scribe: GraphScribe, value: Any, dtype: Any) -> GraphTensor:
    """A constant (1, …) as a stand-in, which has as many rows as there are agents."""
    if isinstance(value, GraphTensor):
        return value.astype(dtype)
    constant = np.asarray(value)
    zeros = scribe.zeros.reshape(1, *[1] * (constant.ndim - 1))
    made: GraphTensor = (zeros + constant.astype(np.float32)).astype(dtype)
    return made


def _reduced(kind: str, function: Any) -> Rule:
    def rule(scribe: GraphScribe, x: Any, axis: int | None = None, dtype: Any = None) -> Any:
        if axis is None or axis % x.ndim == 0:
            refuse(f"numpy.{function.__name__} over all agents")
        whole = x if x.dtype.kind == "f" else x.astype(np.float32)
        example = function(whole.example, axis=axis)
        if kind == "ReduceSum":
            return scribe.node(
                kind, [whole.name, scribe.integers(axis % x.ndim)], example, keepdims=0
            )
        return scribe.node(kind, [whole.name], example, axes=[axis % x.ndim], keepdims=0)

    return rule


def _any(_: GraphScribe, x: Any, axis: int) -> Any:
    return np.max(x, axis=axis) > 0.0


def _all(_: GraphScribe, x: Any, axis: int) -> Any:
    return np.min(x, axis=axis) > 0.0


def _place(kind: str, function: Any) -> Rule:
    def rule(scribe: GraphScribe, x: Any, axis: int) -> Any:
        values = x.astype(np.float32)
        example = function(values.example, axis=axis)
        return scribe.node(kind, [values.name], example, axis=axis % x.ndim, keepdims=0)

    return rule


def _where(scribe: GraphScribe, condition: Any, a: Any, b: Any) -> Any:
    dtype = np.result_type(example_of(a), example_of(b))
    if dtype.kind == "b":
        return (condition & a) | (~condition & b)
    kind = np.float32 if dtype.kind == "f" else np.int64
    parts = [v.astype(dtype) if isinstance(v, GraphTensor) else v for v in (a, b)]
    names = [scribe.name_of(condition, np.bool_), *(scribe.name_of(v, kind) for v in parts)]
    return scribe.node("Where", names, np.where(*map(example_of, (condition, a, b))))


def _like(value: float) -> Rule:
    def rule(scribe: GraphScribe, x: Any, dtype: Any = None) -> Any:
        return _full_like(scribe, x, value, dtype)

    return rule


def _full_like(_: GraphScribe, x: Any, value: float, dtype: Any = None) -> Any:
    return np.full(x.shape, value, dtype or x.dtype)


def _stack(_: GraphScribe, parts: Sequence[Any], axis: int = 0) -> Any:
    return np.concatenate([np.expand_dims(part, axis) for part in parts], axis=axis)


def _hstack(_: GraphScribe, parts: Sequence[Any]) -> Any:
    return np.concatenate(parts, axis=1)


def _concatenate(scribe: GraphScribe, parts: Sequence[Any], axis: int = 0) -> Any:
    example = np.concatenate([example_of(part) for part in parts], axis)
    if axis % example.ndim == 0:
        refuse("numpy.concatenate of agents")
    rows = [for_every_agent(scribe, part, example.dtype) for part in parts]
    return scribe.node("Concat", [row.name for row in rows], example, axis=axis % example.ndim)


def _expand_dims(scribe: GraphScribe, x: Any, axis: int) -> Any:
    example = np.expand_dims(x.example, axis)
    return scribe.node("Unsqueeze", [x.name, scribe.integers(axis % example.ndim)], example)


def _reshape(scribe: GraphScribe, x: Any, shape: tuple[int, ...]) -> Any:
    if shape[0] != 1:
        refuse("a shape that mixes agents")
    target = scribe.integers(0, *shape[1:])  # 0: as many as there are
    return scribe.node("Reshape", [x.name, target], x.example.reshape(shape))


def _clip(_: GraphScribe, x: Any, low: Any, high: Any) -> Any:
    return np.minimum(np.maximum(x, low), high)


def _roll(_: GraphScribe, x: Any, shift: int, axis: int) -> Any:
    order = np.roll(np.arange(x.shape[axis]), shift)
    return x[(slice(None),) * axis + (order,)]


def _diff(_: GraphScribe, x: Any, axis: int = 1) -> Any:
    if axis % x.ndim != 1:
        refuse("numpy.diff along another axis than 1")
    return x[:, 1:] - x[:, :-1]


def _pad(scribe: GraphScribe, x: Any, widths: Any, constant_values: float = 0.0) -> Any:
    (before, after) = np.asarray(widths)[1]
    if x.ndim != 2 or np.asarray(widths)[0].any():
        refuse("numpy.pad along another axis than 1")
    ends = [np.full((1, count), constant_values, x.dtype) for count in (before, after)]
    return np.concatenate([ends[0], x, ends[1]], axis=1)


def _take_along_axis(scribe: GraphScribe, x: Any, places: Any, axis: int) -> Any:
    example = np.take_along_axis(example_of(x), example_of(places), axis)
    if isinstance(x, GraphTensor):
        names = [x.name, scribe.name_of(places, np.int64)]
        return scribe.node("GatherElements", names, example, axis=axis % example.ndim)
    if example.ndim != 2 or len(x) != 1:
        refuse("numpy.take_along_axis of several rows of constants")
    return scribe.node("Gather", [scribe.name_of(x[0]), places.name], example, axis=0)


def _element(scribe: GraphScribe, x: Any, index: Any) -> Any:
    """What an index picks: axis by axis, from the last to the first, then new axes."""
    parts = index if isinstance(index, tuple) else (index,)
    picks = _without_ellipsis([part for part in parts if part is not None], x.ndim)
    if not picks or not isinstance(picks[0], slice) or picks[0] != slice(None):
        refuse("a choice of agents")
    name = x.name
    for axis in reversed(range(len(picks))):
        name = _picked(scribe, name, axis, picks[axis], x.shape[axis])
    new = [i for i, part in enumerate(_without_integers(parts)) if part is None]
    if new:
        name = scribe.graph.node("Unsqueeze", [name, scribe.integers(*new)])
    return scribe.tensor(name, x.example[index])


def _without_ellipsis(picks: list[Any], axes: int) -> list[Any]:
    """One part of an index for each axis that it names."""
    for at in [i for i, part in enumerate(picks) if part is Ellipsis]:
        picks = [*picks[:at], *[slice(None)] * (axes - len(picks) + 1), *picks[at + 1 :]]
    return picks


def _without_integers(parts: tuple[Any, ...]) -> list[Any]:
    """The parts of an index that leave an axis."""
    return [part for part in parts if not isinstance(part, int | np.integer)]


def _picked(scribe: GraphScribe, name: str, axis: int, part: Any, size: int) -> str:
    """The name of a value after one axis of it was indexed."""
    graph, integers = scribe.graph, scribe.integers
    if isinstance(part, int | np.integer):
        cut = [name, *(integers(int(i)) for i in (part % size, part % size + 1, axis))]
        return graph.node("Squeeze", [graph.node("Slice", cut), integers(axis)])
    if isinstance(part, slice):
        start, stop, step = part.indices(size)
        if (start, stop, step) == (0, size, 1):
            return name
        part = np.arange(start, stop, step)
    if isinstance(part, GraphTensor) or np.asarray(part).dtype.kind != "i":
        refuse("an index of this kind")
    return graph.node("Gather", [name, scribe.name_of(np.asarray(part), np.int64)], axis=axis)


FUNCTIONS: dict[Any, Rule] = {
    np.all: _all,
    np.any: _any,
    np.argmax: _place("ArgMax", np.argmax),
    np.argmin: _place("ArgMin", np.argmin),
    np.clip: _clip,
    np.concatenate: _concatenate,
    np.diff: _diff,
    np.expand_dims: _expand_dims,
    np.full_like: _full_like,
    np.hstack: _hstack,
    np.max: _reduced("ReduceMax", np.max),
    np.mean: _reduced("ReduceMean", np.mean),
    np.min: _reduced("ReduceMin", np.min),
    np.ndarray.__getitem__: _element,
    np.ones_like: _like(1.0),
    np.pad: _pad,
    np.reshape: _reshape,
    np.roll: _roll,
    np.stack: _stack,
    np.sum: _reduced("ReduceSum", np.sum),
    np.take_along_axis: _take_along_axis,
    np.where: _where,
    np.zeros_like: _like(0.0),
}
"""NumPy's function → what writes it in ONNX."""
