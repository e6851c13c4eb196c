"""Trials of operators that compute each element by itself."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from onnx import TensorProto

from support.operator_trials.trial import Draw, Drawn, Trial

_SPECIAL = arrays.arrays(np.float32, (3,), elements=st.sampled_from([0.0, np.inf, -np.inf, np.nan]))


def _of_one(low: float, high: float, opset: int = 17, **choices: tuple[Any, ...]) -> Drawn:
    """One input, and attributes of which each is absent or one of some values."""

    def draw(from_: Draw) -> Trial:
        attributes = {name: from_.of(None, *values) for name, values in choices.items()}
        given = {name: value for name, value in attributes.items() if value is not None}
        return Trial([from_.floats(from_.shape(0), low, high)], given, opset=opset)

    return draw


def _of_two(from_: Draw) -> Trial:
    shape = from_.shape()
    inputs: list[Any] = [from_.coarse(shape), from_.coarse(from_.narrower(shape))]
    return Trial(inputs[:: from_.of(1, -1)])


def _of_many(from_: Draw) -> Trial:
    shape = from_.shape()
    others = [from_.coarse(from_.narrower(shape)) for _ in range(from_.whole(0, 2))]
    return Trial([from_.coarse(shape), *others])


def _whole_too(from_: Draw) -> Trial:
    """As `_of_two`, or of whole numbers."""
    if from_.of(True, False):
        return _of_two(from_)
    shape = from_.shape()
    return Trial([from_.ints(shape, -99, 99), from_.ints(from_.narrower(shape), -9, 9)])


def _div(from_: Draw) -> Trial:
    shape = from_.shape()
    if from_.of(True, False):
        return Trial([from_.floats(shape), from_.floats(from_.narrower(shape), 0.5, 9.0)])
    below = from_.ints(shape, 1, 9, np.int32) * from_.of(1, -1)
    return Trial([from_.ints(shape, -99, 99, np.int32), below.astype(np.int32)])


def _pow(from_: Draw) -> Trial:
    shape = from_.shape()
    exponent = from_.floats((), 0.5, 3.0)
    whole = np.array(from_.of(2.0, 3.0), np.float32)
    base = from_.floats(shape, 0.0, 4.0)
    return from_.of(
        Trial([base, exponent], tolerance=1e-5),
        Trial([from_.floats(shape, -4.0, 4.0), whole], tolerance=1e-5),
        Trial([from_.ints(shape, -9, 9), whole]),
        Trial([from_.ints(shape, -9, 9), np.array(2)]),
    )


def _of_truths(count: int) -> Drawn:
    def draw(from_: Draw) -> Trial:
        shape = from_.shape()
        return Trial([from_.truths(shape) for _ in range(count)])

    return draw


def _where(from_: Draw) -> Trial:
    shape = from_.shape()
    condition, other = from_.truths(from_.narrower(shape)), from_.coarse(from_.narrower(shape))
    return Trial([condition, from_.coarse(shape), other])


def _clip(from_: Draw) -> Trial:
    x = from_.floats(from_.shape())
    low, high = from_.of(None, -2.0, 0.5), from_.of(None, -1.0, 2.0)
    if from_.of(True, False):  # where onnxruntime wants limits in order
        attributes = {"min": low, "max": None if high == -1.0 else high}
        return Trial([x], {n: v for n, v in attributes.items() if v is not None}, opset=10)
    limits = [None if limit is None else np.array(limit, np.float32) for limit in (low, high)]
    return Trial([x, *limits])


def _mod(from_: Draw) -> Trial:
    divisor = from_.of(-99, -7, -2, -1, 1, 2, 3, 97)
    return Trial([from_.ints(from_.shape(), -(2**47), 2**47), np.array(divisor)])


def _infinities(from_: Draw) -> Trial:
    x = from_.one(_SPECIAL)
    directions = {"detect_positive": from_.of(0, 1), "detect_negative": from_.of(0, 1)}
    return Trial([x], directions)


def _nan(from_: Draw) -> Trial:
    return Trial([from_.one(_SPECIAL)])


def _cast(from_: Draw) -> Trial:
    numbers = from_.floats(from_.shape(), 0.0, 99.0)
    kinds = (TensorProto.INT64, TensorProto.UINT8, TensorProto.BOOL, TensorProto.FLOAT)
    return from_.of(
        Trial([numbers], {"to": from_.of(*kinds, TensorProto.FLOAT16)}),
        Trial([from_.ints(numbers.shape, 0, 255, np.uint8)], {"to": from_.of(*kinds)}),
    )


def _p_relu(from_: Draw) -> Trial:
    shape = from_.shape()
    return Trial([from_.floats(shape), from_.floats(from_.narrower(shape))])


def _dropout(from_: Draw) -> Trial:
    x = from_.floats(from_.shape())
    return from_.of(Trial([x], {"ratio": 0.3}, opset=11), Trial([x, np.array(0.3, np.float32)]))


ELEMENTS: dict[str, Drawn] = {
    "Abs": _of_one(-9.0, 9.0),
    "Acos": _of_one(-1.0, 1.0),
    "Acosh": _of_one(1.0, 9.0),
    "Add": _whole_too,
    "And": _of_truths(2),
    "Asin": _of_one(-1.0, 1.0),
    "Asinh": _of_one(-9.0, 9.0),
    "Atan": _of_one(-99.0, 99.0),
    "Atanh": _of_one(-0.9, 0.9),
    "Cast": _cast,
    "Ceil": _of_one(-9.0, 9.0),
    "Celu": _of_one(-9.0, 9.0, alpha=(0.5, 2.0)),
    "Clip": _clip,
    "Cos": _of_one(-9.0, 9.0),
    "Cosh": _of_one(-3.0, 3.0),
    "Div": _div,
    "Dropout": _dropout,
    "Elu": _of_one(-9.0, 9.0, alpha=(0.5, 2.0)),
    "Equal": _of_two,
    "Erf": _of_one(-5.0, 5.0),
    "Exp": _of_one(-9.0, 9.0),
    "Floor": _of_one(-9.0, 9.0),
    "Gelu": _of_one(-9.0, 9.0, opset=20, approximate=("none", "tanh")),
    "Greater": _of_two,
    "GreaterOrEqual": _of_two,
    "HardSigmoid": _of_one(-9.0, 9.0, alpha=(0.1, 1.0), beta=(0.0, 0.3)),
    "HardSwish": _of_one(-9.0, 9.0),
    "Identity": _of_one(-9.0, 9.0),
    "IsInf": _infinities,
    "IsNaN": _nan,
    "LeakyRelu": _of_one(-9.0, 9.0, alpha=(0.1, 2.0)),
    "Less": _of_two,
    "LessOrEqual": _of_two,
    "Log": _of_one(1e-3, 99.0),
    "Max": _of_many,
    "Mean": _of_many,
    "Min": _of_many,
    "Mish": _of_one(-9.0, 9.0, opset=18),
    "Mod": _mod,
    "Mul": _whole_too,
    "Neg": _of_one(-9.0, 9.0),
    "Not": _of_truths(1),
    "Or": _of_truths(2),
    "PRelu": _p_relu,
    "Pow": _pow,
    "Reciprocal": _of_one(0.1, 9.0),
    "Relu": _of_one(-9.0, 9.0),
    "Round": _of_one(-3.0, 3.0),
    "Selu": _of_one(-9.0, 9.0, alpha=(0.5, 2.0), gamma=(0.5, 2.0)),
    "Sigmoid": _of_one(-30.0, 30.0),
    "Sign": _of_one(-1.0, 1.0),
    "Sin": _of_one(-9.0, 9.0),
    "Sinh": _of_one(-3.0, 3.0),
    "Softplus": _of_one(-30.0, 30.0),
    "Softsign": _of_one(-9.0, 9.0),
    "Sqrt": _of_one(0.0, 99.0),
    "Sub": _whole_too,
    "Sum": _of_many,
    "Swish": _of_one(-9.0, 9.0, opset=24, alpha=(0.5, 2.0)),
    "Tan": _of_one(-1.4, 1.4),
    "Tanh": _of_one(-9.0, 9.0),
    "ThresholdedRelu": _of_one(-9.0, 9.0, alpha=(0.5, 2.0)),
    "Where": _where,
    "Xor": _of_truths(2),
}
