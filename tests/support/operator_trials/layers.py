"""Trials of layers: convolution, pooling, normalisation and recurrence."""

from typing import Any

import numpy as np

from support.operator_trials.trial import Draw, Drawn, Trial


def _window(from_: Draw, space: list[int], kernel: list[int]) -> dict[str, Any]:
    """Strides and padding of a window that fits."""
    rank = len(kernel)
    strides = [from_.whole(1, 3) for _ in kernel]
    around = [from_.whole(0, (side - 1) // 2) for side in (*kernel, *kernel)]
    auto = {"auto_pad": from_.of("VALID", "SAME_UPPER", "SAME_LOWER", "NOTSET")}
    return from_.of(
        {},
        {"strides": strides},
        {"strides": strides, "pads": around},
        auto,
        {"pads": around[:rank] * 2},
    )


def _conv(from_: Draw) -> Trial:
    rank, group = from_.of(1, 2, 2), from_.of(1, 1, 2)
    kernel = [from_.whole(1, 3) for _ in range(rank)]
    space = [from_.whole(6, 8) for _ in kernel]
    inputs, outputs = group * from_.whole(1, 2), group * from_.whole(1, 2)
    x = from_.normal(from_.whole(1, 3), inputs, *space)
    w = from_.normal(outputs, inputs // group, *kernel)
    attributes = _window(from_, space, kernel)
    if "auto_pad" not in attributes:
        attributes["dilations"] = [from_.whole(1, 2) for _ in kernel]
    shape = from_.of({}, {"kernel_shape": kernel})
    bias = from_.of([], [from_.normal(outputs)])
    return Trial([x, w, *bias], {**attributes, **shape, "group": group}, tolerance=1e-5)


def _pool(from_: Draw) -> tuple[Any, dict[str, Any]]:
    rank = from_.of(1, 2, 2)
    kernel = [from_.whole(1, 3) for _ in range(rank)]
    space = [from_.whole(5, 7) for _ in kernel]
    x = from_.normal(from_.whole(1, 2), from_.whole(1, 2), *space)
    return x, {"kernel_shape": kernel, **_window(from_, space, kernel)}


def _max_pool(from_: Draw) -> Trial:
    x, attributes = _pool(from_)
    if "auto_pad" not in attributes:
        attributes["ceil_mode"] = from_.of(0, 1)
        attributes["dilations"] = [from_.whole(1, 2) for _ in attributes["kernel_shape"]]
    return Trial([x], attributes)


def _average_pool(from_: Draw) -> Trial:
    x, attributes = _pool(from_)
    more = [{"count_include_pad": 1}] if "auto_pad" not in attributes else []
    return Trial([x], {**attributes, **from_.of({}, *more)}, opset=from_.of(11, 17, 19))


def _image(from_: Draw, channels: int) -> Any:
    return from_.normal(from_.whole(1, 3), channels, *from_.shape(1, 2))


def _global(from_: Draw) -> Trial:
    return Trial([_image(from_, from_.whole(1, 3))])


def _batch(from_: Draw) -> Trial:
    channels = from_.whole(1, 3)
    x = from_.of(_image(from_, channels), from_.normal(2, channels))
    variance = np.abs(from_.normal(channels)) + np.float32(0.1)
    numbers = [from_.normal(channels) for _ in range(3)]
    epsilon = from_.of({}, {"epsilon": 1e-3, "momentum": 0.5})
    return Trial([x, *numbers, variance], epsilon, opset=from_.of(9, 14, 17), tolerance=1e-5)


def _layer(from_: Draw) -> Trial:
    shape = from_.shape(1, 3)
    shape[-1] += 3
    axis = from_.axis(shape)
    x, scale = from_.normal(*shape), from_.normal(*shape[axis:])
    bias = from_.of([], [from_.normal(*shape[axis:])])
    return Trial([x, scale, *bias], {"axis": axis, "epsilon": 0.01}, tolerance=1e-5)


def _root_mean_square(from_: Draw) -> Trial:
    shape = from_.shape(1, 3)
    axis = from_.axis(shape)
    inputs: list[Any] = [from_.normal(*shape), from_.normal(*shape[axis:])]
    return Trial(inputs, {"axis": axis}, opset=23, tolerance=1e-5)


def _instance(from_: Draw) -> Trial:
    channels = from_.whole(1, 3)
    x = from_.normal(2, channels, *[side + 2 for side in from_.shape(1, 2)])
    numbers = [from_.normal(channels) for _ in range(2)]
    return Trial([x, *numbers], {"epsilon": 0.01}, tolerance=1e-5)


def _group(from_: Draw) -> Trial:
    groups, opset = from_.whole(1, 3), from_.of(18, 21)
    channels = groups * from_.whole(1, 2)
    x = from_.normal(2, channels, *[side + 2 for side in from_.shape(1, 2)])
    numbers = [from_.normal(groups if opset == 18 else channels) for _ in range(2)]
    return Trial([x, *numbers], {"num_groups": groups, "epsilon": 0.01}, 1, opset, 1e-5)


def _length(from_: Draw) -> Trial:
    x = from_.normal(*from_.shape(2))
    return Trial([x], {"axis": from_.axis(x.shape), "p": from_.of(1, 2)}, tolerance=1e-5)


def _recurrent(gates: int, **choices: tuple[Any, ...]) -> Drawn:
    def draw(from_: Draw) -> Trial:
        steps, n, inputs, size = (from_.whole(1, 4) for _ in range(4))
        rows = gates * size
        shapes = [(steps, n, inputs), (1, rows, inputs), (1, rows, size), (1, 2 * rows)]
        tensors: list[Any] = [from_.normal(*shape) for shape in shapes]
        starts = [from_.normal(1, n, size) for _ in range(2 if gates == 4 else 1)]
        given = from_.of(tensors[:3], tensors, [*tensors, None, *starts])
        chosen = {name: from_.of(*values) for name, values in choices.items()}
        return Trial(given, {"hidden_size": size, **chosen}, 3 if gates == 4 else 2)

    return draw


LAYERS: dict[str, Drawn] = {
    "AveragePool": _average_pool,
    "BatchNormalization": _batch,
    "Conv": _conv,
    "GRU": _recurrent(3, linear_before_reset=(0, 1)),
    "GlobalAveragePool": _global,
    "GlobalMaxPool": _global,
    "GroupNormalization": _group,
    "InstanceNormalization": _instance,
    "LSTM": _recurrent(4),
    "LayerNormalization": _layer,
    "LpNormalization": _length,
    "MaxPool": _max_pool,
    "RMSNormalization": _root_mean_square,
    "RNN": _recurrent(1, activations=(["Tanh"], ["Relu"])),
}
