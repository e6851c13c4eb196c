"""Rules for what slides along rays or images: convolutions, pools and padding.

A ring of rays, an image that is mirrored at its edge: such padding is joined from pieces.
"""

from typing import Any

import torch
from torch import nn
from torch.nn import functional as F  # noqa: N812  # its usual name

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import Call, Rule, Translation, Value
from reflexarc_trainer.policy.translation.parameters import weights


def _convolution(call: Call) -> str:
    """`nn.Conv1d` and `nn.Conv2d`."""
    graph, module, x = call.graph, call.module, _batched(call, len(call.module.kernel_size))
    pads = _padding(module)
    name = x.name
    if module.padding_mode != "zeros":
        name = _padded(graph, x, 2, pads, module.padding_mode)
        pads = [(0, 0)] * len(pads)
    inputs = [name, graph.constant("weight", weights(module.weight))]
    if module.bias is not None:
        inputs.append(graph.constant("bias", weights(module.bias)))
    return graph.node(
        "Conv",
        inputs,
        kernel_shape=list(module.kernel_size),
        strides=list(module.stride),
        dilations=list(module.dilation),
        group=module.groups,
        pads=[*(low for low, _ in pads), *(high for _, high in pads)],
    )


def _padding(module: Any) -> list[tuple[int, int]]:
    """Before and behind, for each axis; of an odd number the larger part goes behind."""
    if module.padding == "valid":
        return [(0, 0)] * len(module.kernel_size)
    if module.padding == "same":
        pairs = zip(module.kernel_size, module.dilation, strict=True)
        totals = [dilation * (size - 1) for size, dilation in pairs]
        return [(total // 2, total - total // 2) for total in totals]
    return [(size, size) for size in module.padding]


def _pool(kind: str, rank: int) -> Rule:
    def rule(call: Call) -> str:
        x, of_max = _batched(call, rank), kind == "MaxPool"
        given = _max_options(call) if of_max else _mean_options(call)
        kernel, pads = _spread(given["kernel_size"], rank), _spread(given["padding"], rank)
        stride = _spread(given["stride"] or given["kernel_size"], rank)
        _refuse(given, x, kernel, stride, pads)
        more: dict[str, Any] = (
            {"dilations": _spread(given["dilation"], rank)}
            if of_max
            else {"count_include_pad": int(given["count_include_pad"])}
        )
        return call.graph.node(
            kind, [x.name], kernel_shape=kernel, strides=stride, pads=[*pads, *pads], **more
        )

    return rule


def _max_options(call: Call) -> dict[str, Any]:
    names = ("kernel_size", "stride", "padding", "dilation", "ceil_mode", "return_indices")
    defaults = {"stride": None, "padding": 0, "dilation": 1}
    return call.options(*names, **defaults, ceil_mode=False, return_indices=False)


def _mean_options(call: Call) -> dict[str, Any]:
    names = ("kernel_size", "stride", "padding", "ceil_mode", "count_include_pad")
    defaults = {"stride": None, "padding": 0, "ceil_mode": False}
    return call.options(*names, **defaults, count_include_pad=True)


def _refuse(
    given: dict[str, Any], x: Value, kernel: list[int], stride: list[int], pads: list[int]
) -> None:
    if given.get("return_indices"):
        raise PolicyError("export: a pool with return_indices=True is not supported")
    if given["ceil_mode"] and any(
        (size + 2 * pad - width) % step
        for size, width, step, pad in zip(x.shape[2:], kernel, stride, pads, strict=True)
        if size is not None
    ):
        raise PolicyError("export: a pool whose last window ends outside is not supported")


def _adaptive(kind: str, reduced: str) -> Rule:
    """A pool to a given size, which has to divide that of the input; to 1: along whole axes."""

    def rule(call: Call) -> str:
        graph = call.graph
        x = _batched(call, len(call.result) - 2)
        axes = list(range(2, len(x.shape)))
        sizes, wanted = x.shape[2:], call.result[2:]
        if all(size == 1 for size in wanted):
            return graph.node(reduced, [x.name], axes=axes, keepdims=1)
        if any(size % want for size, want in zip(sizes, wanted, strict=True)):
            raise PolicyError(
                f"export: an adaptive pool from {tuple(sizes)} to {tuple(wanted)} is not "
                "supported; expected sizes that divide"
            )
        kernel = [size // want for size, want in zip(sizes, wanted, strict=True)]
        return graph.node(kind, [x.name], kernel_shape=kernel, strides=kernel)

    return rule


def _pad(call: Call) -> str:
    """`F.pad`: pairs for the last axis, then for the one before it, and so on."""
    given = call.given("pad", "mode", "value", mode="constant", value=None)
    pairs = list(zip(given["pad"][::2], given["pad"][1::2], strict=True))[::-1]
    x: Value = call.args[0]
    first = len(x.shape) - len(pairs)
    return _padded(call.graph, x, first, pairs, given["mode"], given["value"] or 0.0)


def _padding_module(mode: str) -> Rule:
    def rule(call: Call) -> str:
        flat = call.module.padding
        pairs = list(zip(flat[::2], flat[1::2], strict=True))[::-1]
        x: Value = call.args[0]
        value = getattr(call.module, "value", 0.0)
        return _padded(call.graph, x, len(x.shape) - len(pairs), pairs, mode, value)

    return rule


def _padded(
    graph: Translation,
    x: Value,
    first: int,
    pairs: list[tuple[int, int]],
    mode: str,
    value: float = 0.0,
) -> str:
    """With more elements along the axes from `first` on."""
    name = x.name
    for axis, (before, behind) in enumerate(pairs, start=first):
        size = x.shape[axis]
        if size is None or min(before, behind) < 0:
            raise PolicyError("export: a padding of the batch, or a negative one, is not supported")
        if before or behind:
            front = _edge(graph, name, axis, size, mode, _places(mode, size, before, -1), value)
            back = _edge(graph, name, axis, size, mode, _places(mode, size, behind, 1), value)
            name = graph.node("Concat", [*front, name, *back], axis=axis)
    return name


def _places(mode: str, size: int, count: int, side: int) -> list[int]:
    """Which elements the new ones are copies of, in the order of the axis."""
    steps = range(1, count + 1)
    match mode:
        case "circular" if count <= size:
            places = [(side * step - (side > 0)) % size for step in steps]
        case "replicate" | "constant":
            places = [0 if side < 0 else size - 1 for _ in steps]
        case "reflect" if count < size:
            places = [step if side < 0 else size - 1 - step for step in steps]
        case _:
            raise PolicyError(f"export: a {mode} padding of {count} for {size} is not supported")
    return places if side > 0 else places[::-1]


def _edge(
    graph: Translation,
    name: str,
    axis: int,
    size: int,
    mode: str,
    places: list[int],
    value: float,
) -> list[str]:
    """Names of slices of one element; for a constant, of such a slice times 0."""
    pieces = []
    for place in places:
        ends = [graph.integers("ends", place), graph.integers("ends", place + 1)]
        piece = graph.node("Slice", [name, *ends, graph.integers("axes", axis)])
        if mode == "constant":
            piece = graph.node("Mul", [piece, graph.number(0.0)])
            piece = graph.node("Add", [piece, graph.number(value)]) if value else piece
        pieces.append(piece)
    return pieces


def _batched(call: Call, rank: int) -> Value:
    x: Value = call.args[0]
    if len(x.shape) != rank + 2 or x.shape[0] is not None:
        axes = ("length",) if rank == 1 else ("height", "width")
        shape = ", ".join("n" if size is None else str(size) for size in x.shape)
        raise PolicyError(
            f"export: expected an input (n, channels, {', '.join(axes)}) of a convolution or "
            f"pool, got ({shape})"
        )
    return x


def _spread(size: Any, rank: int) -> list[int]:
    return list(size) if isinstance(size, tuple | list) else [int(size)] * rank


WINDOW_RULES: dict[Any, Rule] = {
    **dict.fromkeys((nn.Conv1d, nn.Conv2d), _convolution),
    **dict.fromkeys((nn.MaxPool1d, F.max_pool1d, torch.max_pool1d), _pool("MaxPool", 1)),
    **dict.fromkeys((nn.MaxPool2d, F.max_pool2d, torch.max_pool2d), _pool("MaxPool", 2)),
    **dict.fromkeys((nn.AvgPool1d, F.avg_pool1d), _pool("AveragePool", 1)),
    **dict.fromkeys((nn.AvgPool2d, F.avg_pool2d), _pool("AveragePool", 2)),
    **dict.fromkeys(
        (nn.AdaptiveAvgPool1d, nn.AdaptiveAvgPool2d, F.adaptive_avg_pool1d, F.adaptive_avg_pool2d),
        _adaptive("AveragePool", "ReduceMean"),
    ),
    **dict.fromkeys(
        (nn.AdaptiveMaxPool1d, nn.AdaptiveMaxPool2d, F.adaptive_max_pool1d, F.adaptive_max_pool2d),
        _adaptive("MaxPool", "ReduceMax"),
    ),
    F.pad: _pad,
    **dict.fromkeys((nn.CircularPad1d, nn.CircularPad2d), _padding_module("circular")),
    **dict.fromkeys((nn.ReplicationPad1d, nn.ReplicationPad2d), _padding_module("replicate")),
    **dict.fromkeys((nn.ReflectionPad1d, nn.ReflectionPad2d), _padding_module("reflect")),
    **dict.fromkeys(
        (nn.ConstantPad1d, nn.ConstantPad2d, nn.ZeroPad1d, nn.ZeroPad2d),
        _padding_module("constant"),
    ),
}
"""Class, function or method name of a traced call → what writes it in ONNX."""
