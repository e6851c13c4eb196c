"""Trials of operators of shape, with axes and sizes as attributes and as inputs."""

import numpy as np
from onnx import numpy_helper

from support.onnx_nodes import Array
from support.operator_trials.trial import Draw, Drawn, Trial, filled, ints

_ENDS = (*range(-6, 7), 2**31 - 1, -(2**31), 2**63 - 1, -(2**63))


def _concat(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.axis(shape)
    parts: list[Array | None] = []
    for _ in range(from_.whole(1, 3)):
        shape[axis] = from_.whole(1, 3)
        parts.append(filled(shape))
    return Trial(parts, {"axis": axis})


def _constant(from_: Draw) -> Trial:
    array = from_.of(filled([2, 3]), ints(1, 2), np.array(True), np.array(0.5, np.float64))
    return from_.of(
        Trial([], {"value": numpy_helper.from_array(array)}),
        Trial([], {"value_float": 0.1}),
        Trial([], {"value_floats": [0.1, 2.0]}),
        Trial([], {"value_int": 3}),
        Trial([], {"value_ints": [3, -4]}),
    )


def _constant_of_shape(from_: Draw) -> Trial:
    value = from_.of(np.array([0.5], np.float32), np.array([3]), np.array([True]))
    given = from_.of({}, {"value": numpy_helper.from_array(value)})
    return Trial([ints(*from_.shape(0))], given)


def _range(from_: Draw) -> Trial:
    start, end, step = from_.whole(-9, 9), from_.whole(-9, 9), from_.of(-3, -1, 1, 2)
    return Trial([np.array(number) for number in (start, end, step)])


def _shape(from_: Draw) -> Trial:
    ends = {"start": from_.whole(-5, 5), "end": from_.whole(-5, 5)}
    return Trial([filled(from_.shape(0))], from_.of({}, ends))


def _flatten(from_: Draw) -> Trial:
    shape = from_.shape()
    return Trial([filled(shape)], from_.of({}, {"axis": from_.whole(-len(shape), len(shape))}))


def _reshape(from_: Draw) -> Trial:
    shape = from_.shape(2)
    wanted = from_.of([-1], [0, -1], [shape[0], -1], [1, *shape], [0, 0, *shape[2:]], [-1, 1])
    return Trial([filled(shape), ints(*wanted)])


def _transpose(from_: Draw) -> Trial:
    shape = from_.shape()
    order = sorted(range(len(shape)), key=lambda axis: from_.whole(0, 9))
    return Trial([filled(shape)], from_.of({}, {"perm": order}))


def _slice(from_: Draw) -> Trial:
    shape = from_.shape()
    axes = from_.axes(shape, least=1)
    starts, stops = ([from_.of(*_ENDS) for _ in axes] for _ in range(2))
    steps = [from_.of(1, 1, 2, 3, -1, -2) for _ in axes]
    x, cuts = filled(shape), [ints(*starts), ints(*stops)]
    old = {"starts": starts, "ends": stops, "axes": [axis % len(shape) for axis in axes]}
    return from_.of(
        Trial([x, *cuts, ints(*axes), ints(*steps)]),
        Trial([x, *cuts, ints(*axes)]),
        Trial([x, *cuts]),
        Trial([x], old, opset=9),
    )


def _split(from_: Draw) -> Trial:
    shape = from_.shape()
    axis, parts = from_.axis(shape), [from_.whole(1, 3) for _ in range(from_.whole(1, 3))]
    count = len(parts)
    shape[axis] = sum(parts)
    along = {"axis": axis}
    uneven = [
        Trial([filled(shape), ints(*parts)], along, count),
        Trial([filled(shape)], {**along, "split": parts}, count, opset=11),
    ]
    shape[axis] = count * from_.whole(1, 2)
    even = [
        Trial([filled(shape)], along, count),
        Trial([filled(shape)], {**along, "num_outputs": count}, count, opset=18),
    ]
    return from_.of(*uneven, *even)


def _unsqueeze(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.whole(0, len(shape))
    negative = axis - len(shape) - 1
    old = Trial([filled(shape)], {"axes": [axis]}, opset=11)
    return from_.of(old, Trial([filled(shape), ints(from_.of(axis, negative))]))


def _squeeze(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.whole(0, len(shape))
    shape.insert(axis, 1)
    x = filled(shape)
    old = Trial([x], {"axes": [axis]}, opset=11)
    return from_.of(old, Trial([x, ints(axis - from_.of(0, len(shape)))]), Trial([x]))


def _expand(from_: Draw) -> Trial:
    shape = from_.shape()
    given, wanted = from_.of((shape, from_.narrower(shape)), (from_.narrower(shape), shape))
    return Trial([filled(given), ints(*wanted)])


def _tile(from_: Draw) -> Trial:
    shape = from_.shape()
    return Trial([filled(shape), ints(*[from_.whole(1, 3) for _ in shape])])


def _pad(from_: Draw) -> Trial:
    shape = [from_.whole(3, 5) for _ in range(from_.whole(1, 3))]
    widths = [from_.whole(-1, 2) for _ in range(2 * len(shape))]
    x, value = filled(shape), np.array(7.0, np.float32)
    mode = {"mode": from_.of("constant", "edge", "reflect")}
    positive = [max(width, 0) for width in widths]
    last = ints(*widths[:2])
    return from_.of(
        Trial([x, ints(*widths), value]),
        Trial([x, ints(*widths)]),
        Trial([x, ints(*positive)], mode),
        Trial([x, ints(*positive)], {"mode": "wrap"}, opset=19),
        Trial([x, last, value, ints(-1)], opset=18),
        Trial([x], {"pads": positive, "value": 3.0}, opset=10),
    )


def _triangle(from_: Draw) -> Trial:
    x, upper = filled(from_.shape(2)), {"upper": from_.of(0, 1)}
    return from_.of(Trial([x], upper), Trial([x, np.array(from_.whole(-3, 3))], upper))


SHAPES: dict[str, Drawn] = {
    "Concat": _concat,
    "Constant": _constant,
    "ConstantOfShape": _constant_of_shape,
    "Expand": _expand,
    "Flatten": _flatten,
    "Pad": _pad,
    "Range": _range,
    "Reshape": _reshape,
    "Shape": _shape,
    "Size": lambda from_: Trial([filled(from_.shape(0))]),
    "Slice": _slice,
    "Split": _split,
    "Squeeze": _squeeze,
    "Tile": _tile,
    "Transpose": _transpose,
    "Trilu": _triangle,
    "Unsqueeze": _unsqueeze,
}
