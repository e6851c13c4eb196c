"""Rules for what cuts, joins and turns tensors, without computing anything."""

import operator
from collections.abc import Iterator
from typing import Any

import torch

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import Call, Rule, Shape, Translation, Value


def _flatten(call: Call) -> str:
    given = {"start_dim": 0, "end_dim": -1}
    if call.module is not None:
        given = {"start_dim": call.module.start_dim, "end_dim": call.module.end_dim}
    given = call.given("start_dim", "end_dim", **given)
    if given == {"start_dim": 1, "end_dim": -1}:
        return call.graph.node("Flatten", [call.args[0].name], axis=1)
    return _reshape(call)


def _reshape(call: Call) -> str:
    """Whatever was asked for: the shape that came out of it is known."""
    if call.result.count(None) > 1:
        raise PolicyError("export: a shape with the size of the batch twice is not supported")
    sizes = (-1 if size is None else size for size in call.result)
    return call.graph.node("Reshape", [call.args[0].name, call.graph.integers("shape", *sizes)])


def _concat(call: Call) -> str:
    given = call.given("dim", "axis", dim=0)
    parts: tuple[Value, ...] = call.args[0]
    axis = _axis(given.get("axis", given["dim"]), len(call.result))
    return call.graph.node("Concat", [part.name for part in parts], axis=axis)


def _stack(call: Call) -> str:
    axis = _axis(call.given("dim", dim=0)["dim"], len(call.result))
    rows = [_unsqueezed(call.graph, part.name, axis) for part in call.args[0]]
    return call.graph.node("Concat", rows, axis=axis)


def _split(call: Call) -> tuple[str, ...]:
    """Both `chunk` and `split`: the sizes of the parts are known."""
    names = ("sizes", "chunks", "split_size", "split_size_or_sections", "split_sizes")
    axis = call.kwargs.get("dim", call.args[2] if len(call.args) > 2 else 0)
    others = call.kwargs.keys() - {"dim", *names}
    if others:
        raise PolicyError(f"export: split with {', '.join(others)} is not supported")
    whole: Value = call.args[0]
    axis = _axis(axis, len(whole.shape))
    if whole.shape[axis] is None:
        raise PolicyError("export: the batch cannot be split")
    sizes = call.graph.integers("sizes", *(part[axis] for part in call.result))
    return call.graph.many("Split", [whole.name, sizes], len(call.result), axis=axis)


def _unsqueeze(call: Call) -> str:
    axis = _axis(call.given("dim")["dim"], len(call.result))
    return _unsqueezed(call.graph, call.args[0].name, axis)


def _squeeze(call: Call) -> str:
    whole: Value = call.args[0]
    rank = len(whole.shape)
    dims = call.given("dim", dim=tuple(range(rank)))["dim"]
    wanted = {_axis(dim, rank) for dim in (dims if isinstance(dims, tuple | list) else (dims,))}
    axes = sorted(axis for axis in wanted if whole.shape[axis] == 1)
    return _squeezed(call.graph, whole.name, axes)


def _transpose(call: Call) -> str:
    given = call.given("dim0", "dim1")
    rank = len(call.args[0].shape)
    axes = list(range(rank))
    first, second = (_axis(given[name], rank) for name in ("dim0", "dim1"))
    axes[first], axes[second] = second, first
    return call.graph.node("Transpose", [call.args[0].name], perm=axes)


def _permute(call: Call) -> str:
    dims = call.kwargs.get("dims", call.args[1:])
    dims = dims[0] if len(dims) == 1 and isinstance(dims[0], tuple | list) else dims
    axes = [_axis(dim, len(call.result)) for dim in dims]
    return call.graph.node("Transpose", [call.args[0].name], perm=axes)


def _item(call: Call) -> str:
    """`x[…]` with numbers, slices, None and an ellipsis."""
    whole, index = call.args[0], call.args[1]
    index = list(index) if isinstance(index, tuple | list) else [index]
    cuts, gone, new = _read(index, whole.shape)
    name = _sliced(call.graph, whole.name, cuts)
    name = _squeezed(call.graph, name, gone)
    for axis in new:
        name = _unsqueezed(call.graph, name, axis)
    return name


def _read(
    index: list[Any], shape: Shape
) -> tuple[dict[int, tuple[int, int, int]], list[int], list[int]]:
    """An index as: what each axis is cut to, which axes then vanish, and where new ones appear."""
    cuts: dict[int, tuple[int, int, int]] = {}
    gone, new, axis, place = [], [], 0, 0
    for item in _spread(index, len(shape)):
        if item is None:
            new.append(place)
        elif isinstance(item, slice):
            cuts |= _cut(axis, item, shape[axis])
            axis += 1
        else:
            cuts |= _cut(axis, _one(item), shape[axis])
            gone.append(axis)
            axis += 1
            continue
        place += 1
    return cuts, gone, new


def _spread(index: list[Any], rank: int) -> Iterator[Any]:
    """The index with an item for every axis."""
    missing = rank - sum(item is not None and item is not Ellipsis for item in index)
    if Ellipsis not in index:
        index = [*index, Ellipsis]
    for item in index:
        if item is Ellipsis:
            yield from [slice(None)] * missing
        else:
            yield item


def _one(item: Any) -> slice:
    if not isinstance(item, int):
        raise PolicyError(f"export: an index of {type(item).__name__} is not supported")
    return slice(item, item + 1 if item != -1 else None)


def _cut(axis: int, item: slice, size: int | None) -> dict[int, tuple[int, int, int]]:
    if item == slice(None):
        return {}
    if size is None:
        raise PolicyError("export: an index into the batch is not supported")
    return {axis: item.indices(size)}


def _sliced(graph: Translation, name: str, cuts: dict[int, tuple[int, int, int]]) -> str:
    if not cuts:
        return name
    columns = zip(*cuts.values(), strict=True)
    starts, ends, steps = (
        graph.integers(word, *column)
        for word, column in zip(("starts", "ends", "steps"), columns, strict=True)
    )
    return graph.node("Slice", [name, starts, ends, graph.integers("axes", *cuts), steps])


def _squeezed(graph: Translation, name: str, axes: list[int]) -> str:
    return graph.node("Squeeze", [name, graph.integers("axes", *axes)]) if axes else name


def _unsqueezed(graph: Translation, name: str, axis: int) -> str:
    return graph.node("Unsqueeze", [name, graph.integers("axes", axis)])


def _axis(axis: Any, rank: int) -> int:
    """An axis counted from the front."""
    return int(axis) % rank


SHAPE_RULES: dict[Any, Rule] = {
    operator.getitem: _item,
    **dict.fromkeys((torch.nn.Flatten, torch.flatten, "flatten"), _flatten),
    **dict.fromkeys(
        (torch.reshape, "reshape", "view", torch.unflatten, "unflatten", torch.nn.Unflatten),
        _reshape,
    ),
    **dict.fromkeys((torch.cat, torch.concat, torch.concatenate), _concat),
    torch.stack: _stack,
    **dict.fromkeys((torch.chunk, "chunk", torch.split, "split"), _split),
    **dict.fromkeys((torch.unsqueeze, "unsqueeze"), _unsqueeze),
    **dict.fromkeys((torch.squeeze, "squeeze"), _squeeze),
    **dict.fromkeys((torch.transpose, "transpose", torch.swapaxes, "swapaxes"), _transpose),
    **dict.fromkeys((torch.permute, "permute"), _permute),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
