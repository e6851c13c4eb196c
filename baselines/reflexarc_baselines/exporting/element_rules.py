"""NumPy's functions of elements (ufuncs) as ONNX nodes."""

from typing import Any

import numpy as np

from reflexarc_baselines.exporting.graph_tensor import GraphScribe, GraphTensor, Rule, refuse


def example_of(value: Any) -> Any:
    """The example of a stand-in; anything else is one itself."""
    return value.example if isinstance(value, GraphTensor) else value


def written(scribe: GraphScribe, kind: str, function: Any, *inputs: Any) -> Any:
    """One node whose inputs are numbers of one kind: that with which NumPy computes."""
    example = function(*map(example_of, inputs))
    common = np.result_type(*map(example_of, inputs))
    dtype = example.dtype if example.dtype.kind == "f" else common
    if dtype == np.uint8:
        refuse("arithmetic of bytes")
    alike = [i.astype(dtype) if isinstance(i, GraphTensor) else i for i in inputs]
    plain = {"f": np.float32, "b": np.bool_}.get(dtype.kind, np.int64)
    return scribe.node(kind, [scribe.name_of(i, plain) for i in alike], example)


def _plain(kind: str, ufunc: Any) -> Rule:
    return lambda scribe, *inputs: written(scribe, kind, ufunc, *inputs)


def _square(_: GraphScribe, x: Any) -> Any:
    return np.multiply(x, x)


def _power(scribe: GraphScribe, x: Any, exponent: Any) -> Any:
    if np.ndim(exponent) == 0 and exponent == 2:
        return np.multiply(x, x)
    return written(scribe, "Pow", np.power, x, exponent)


def _hypot(_: GraphScribe, x: Any, y: Any) -> Any:
    return np.sqrt(np.multiply(x, x) + np.multiply(y, y))


def _remainder(scribe: GraphScribe, a: Any, b: Any) -> Any:
    if np.result_type(example_of(a), example_of(b)).kind != "f":
        return written(scribe, "Mod", np.mod, a, b)
    return np.subtract(a, np.multiply(b, np.floor(np.divide(a, b))))


def _arctan2(_: GraphScribe, y: Any, x: Any) -> Any:
    """The arc tangent of y/x, turned by half a circle behind; 0 where both are 0."""
    zero, half = np.float32(0.0), np.float32(np.pi)
    is_none = np.logical_and(np.equal(x, zero), np.equal(y, zero))
    ahead = np.arctan(np.divide(y, np.where(is_none, np.float32(1.0), x)))
    return ahead + np.where(np.less(x, zero), np.where(np.less(y, zero), -half, half), zero)


def _different(_: GraphScribe, a: Any, b: Any) -> Any:
    return np.logical_not(np.equal(a, b))


def _accumulated(ufunc: Any) -> Rule:
    """Along axis 1, by doubling: after k rounds each element knows of the 2ᵏ − 1 before it."""

    def rule(_: GraphScribe, x: Any, axis: int) -> Any:
        if axis != 1:
            refuse(f"numpy.{ufunc.__name__}.accumulate along another axis than 1")
        reach = 1
        while reach < x.shape[1]:
            known = ufunc(x[:, reach:], x[:, :-reach])
            x, reach = np.concatenate([x[:, :reach], known], axis=1), 2 * reach
        return x

    return rule


_OF_FLOATS = {
    np.absolute: "Abs",
    np.arccos: "Acos",
    np.arcsin: "Asin",
    np.arctan: "Atan",
    np.cos: "Cos",
    np.exp: "Exp",
    np.floor: "Floor",
    np.log: "Log",
    np.negative: "Neg",
    np.sign: "Sign",
    np.sin: "Sin",
    np.sqrt: "Sqrt",
    np.tanh: "Tanh",
}
_OF_TWO = {
    np.add: "Add",
    np.bitwise_and: "And",
    np.bitwise_or: "Or",
    np.divide: "Div",
    np.equal: "Equal",
    np.greater: "Greater",
    np.greater_equal: "GreaterOrEqual",
    np.invert: "Not",
    np.less: "Less",
    np.less_equal: "LessOrEqual",
    np.logical_and: "And",
    np.logical_not: "Not",
    np.logical_or: "Or",
    np.matmul: "MatMul",
    np.maximum: "Max",
    np.minimum: "Min",
    np.multiply: "Mul",
    np.subtract: "Sub",
}

UFUNCS: dict[Any, Rule] = {
    **{ufunc: _plain(kind, ufunc) for ufunc, kind in (_OF_FLOATS | _OF_TWO).items()},
    (np.maximum, "accumulate"): _accumulated(np.maximum),
    (np.minimum, "accumulate"): _accumulated(np.minimum),
    np.arctan2: _arctan2,
    np.hypot: _hypot,
    np.not_equal: _different,
    np.power: _power,
    np.remainder: _remainder,
    np.square: _square,
}
"""NumPy's ufunc → what writes it in ONNX."""
