"""How far float32 may lie from the reference, for a network's own weights.

The bound is found by running the graph once with values that carry their errors
(`running_error.py`), for the inputs that the export is checked with. For these it is proved: no
order of summation, no vector width and no fused multiplication gives more. For others it is not,
but it counts the worst luck in every operation, tens of times what luck gives; it takes every unit
at its steepest; and the brightest retina, with which a first layer rounds most, is always among
the inputs.

A bound for every possible input, from ranges in place of values, was up to 100 times larger for
networks with a memory, whose gates it takes as open and shut at once; and for the cell of an LSTM,
which may grow without end, there is none.

It holds for one tick, from a memory that both backends are given: that is what a replay compares.
In a sequence each tick adds its own error, so k ticks are allowed k times as much (`parity.py`).
"""

import math
from collections.abc import Callable, Iterator
from functools import reduce
from typing import Any, TypeAlias

import numpy as np
import onnx
from onnx import numpy_helper

from reflexarc_runtime.policy.agreement import Q_TOLERANCE
from reflexarc_runtime.policy.operators.operator_table import operator_of
from reflexarc_trainer.policy.probes import Probes
from reflexarc_trainer.policy.rounding import activation_errors as activations
from reflexarc_trainer.policy.rounding import choice_errors as choice
from reflexarc_trainer.policy.rounding import function_errors as functions
from reflexarc_trainer.policy.rounding import window_errors as windows
from reflexarc_trainer.policy.rounding.recurrent_errors import gru, lstm
from reflexarc_trainer.policy.rounding.running_error import (
    TINY,
    UNIT,
    Running,
    add,
    affine,
    divide,
    exactly,
    multiply,
    relu,
    sigmoid,
    square_root,
    subtract,
    tanh,
)

LARGEST_TOLERANCE = 1e-2
"""Beyond it two backends would do different things, and damage would pass for rounding."""
_VALUES_AT_A_TIME = 1 << 22
"""Of the inputs: thousands of large retinas would need gigabytes."""

Error: TypeAlias = Callable[..., Any]


def tolerance_for(bound: float, least: float = Q_TOLERANCE) -> float:
    """The `q_tolerance` for a network: its rounding bound, rounded up to two digits.

    Where the bound exceeds the largest tolerance, that one is taken: it assumes the worst luck, so
    whether the network agrees is still to be measured.

    Args:
        bound: what `rounding_bound` says.
        least: what it is at least.
    """
    tolerance = LARGEST_TOLERANCE if bound >= LARGEST_TOLERANCE else _two_digits(bound)
    return max(least, Q_TOLERANCE, tolerance)


def rounding_bound(model: onnx.ModelProto, probes: Probes) -> float:
    """Largest |float32 − reference| / max(1, |reference|) of Q-values and memories, in one tick.

    Infinite if the graph has an operator for which no bound is known, or divides by what may be 0.
    """
    if any(node.op_type not in _KNOWN for node in model.graph.node):
        return math.inf
    with np.errstate(all="ignore"):  # what is not finite has no bound
        bounds = [_relative(output) for output in _outputs(model, probes)]
    # Not a number is no bound either.
    return max(bounds) if all(map(math.isfinite, bounds)) else math.inf


def _two_digits(value: float) -> float:
    """Rounded up, to be readable: 3.142e-6 becomes 3.2e-6."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / digit) * digit:.1e}")


def _relative(output: Running) -> float:
    """The reference is rounded too, by u |Q|, and so is the difference when it is compared."""
    scale = np.maximum(1.0, np.abs(output.value))
    return float(np.max(output.error / scale)) + 2 * UNIT


def _outputs(model: onnx.ModelProto, probes: Probes) -> Iterator[Running]:
    constants = {t.name: exactly(numpy_helper.to_array(t)) for t in model.graph.initializer}
    batch = max(1, _VALUES_AT_A_TIME // probes.retinas[0].size)
    for start in range(0, len(probes.retinas), batch):
        some = slice(start, start + batch)
        values: dict[str, Any] = {"": None, **constants, "retina": exactly(probes.retinas[some])}
        if probes.memories is not None:
            values["state"] = exactly(probes.memories[some])
        for node in model.graph.node:
            _run(node, values)
        yield from (values[name] for name in ("q_values", "state_next") if name in values)


def _run(node: onnx.NodeProto, values: dict[str, Any]) -> None:
    if node.op_type == "ArgMax" and node.output[0] == "action":
        return
    inputs = [values[name] for name in node.input]
    attributes = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
    if node.op_type in _MOVES:
        results = _moved(node, inputs)
    elif node.op_type in _WINDOWS:
        results = _WINDOWS[node.op_type](operator_of(node), attributes, *inputs)
    else:
        results = _ERRORS[node.op_type](attributes, *inputs)
    results = results if isinstance(results, tuple) else (results,)
    values.update((n, r) for n, r in zip(node.output, results, strict=False) if n)


def _moved(node: onnx.NodeProto, inputs: list[Any]) -> Any:
    """What only moves elements does so with values and errors, by the reference's own operator."""
    whole = inputs if node.op_type == "Concat" else inputs[:1]
    others = [x.value.astype(np.int64) for x in inputs[len(whole) :]]
    move = operator_of(node)
    values = move(*[x.value for x in whole], *others)
    errors = move(*[x.error for x in whole], *others)
    if isinstance(values, tuple):
        return tuple(Running(*pair) for pair in zip(values, errors, strict=True))
    return Running(values, errors, all(x.is_whole for x in whole))


def _gemm(attributes: dict[str, Any], a: Running, b: Running, c: Running | None = None) -> Running:
    assert attributes == {"transB": 1}  # the exporter writes no other
    return _product(a, b.map(np.transpose), *(() if c is None else (c,)))


def _mat_mul(_: dict[str, Any], a: Running, b: Running) -> Running:
    return _product(a, b)


def _product(x: Running, weights: Running, *biases: Running) -> Running:
    """With weights that are constants, in most cases; else of two that were both computed."""
    known = not any(part.error.any() for part in (weights, *biases))
    if known and x.is_whole and weights.is_whole:
        return Running(x.value @ weights.value, x.error @ np.abs(weights.value), is_whole=True)
    if known and weights.value.ndim == 1:
        return _product(x, weights.map(lambda row: row[:, np.newaxis])).map(lambda y: y[..., 0])
    if not known or weights.value.ndim != 2:
        return windows.product(x, weights)
    return affine(x, weights.value, *(bias.value for bias in biases))


def _plain(error: Callable[..., Running]) -> Error:
    return lambda _, *inputs: error(*inputs)


def _of_any_number(error: Callable[[Running, Running], Running]) -> Error:
    return lambda _, *inputs: reduce(error, inputs)


def _erf(x: Running) -> Running:
    return activations.error_function(x, _REFERENCE_ERF(x.value))


def _clip(x: Running, low: Running | None = None, high: Running | None = None) -> Running:
    raised = x if low is None else functions.larger(x, low)
    return raised if high is None else functions.smaller(raised, high)


_REFERENCE_ERF = operator_of(onnx.helper.make_node("Erf", ["x"], ["y"]))
_MOVES = frozenset(
    ("Concat", "Flatten", "Reshape", "Slice", "Split", "Squeeze", "Transpose", "Unsqueeze")
)
_ERRORS: dict[str, Error] = {
    "Abs": _plain(functions.absolute),
    "Acos": _plain(functions.monotone(np.arccos, -1.0, 1.0)),
    "Add": _plain(add),
    "And": _plain(choice.both),
    "ArgMax": choice.place_of_largest,
    "ArgMin": choice.place_of_smallest,
    "Asin": _plain(functions.monotone(np.arcsin, -1.0, 1.0)),
    "Atan": _plain(functions.monotone(np.arctan)),
    "Cast": functions.cast,
    "Clip": _plain(_clip),
    "Cos": _plain(functions.wave(np.cos)),
    "Div": _plain(divide),
    "Elu": activations.elu,
    "Equal": _plain(choice.comparison(np.equal)),
    "Erf": _plain(_erf),
    "Exp": _plain(functions.monotone(np.exp)),
    "Floor": _plain(choice.floor),
    "GRU": gru,
    "Gather": choice.elements,
    "GatherElements": choice.elements_along,
    "Gemm": _gemm,
    "Greater": _plain(choice.comparison(np.greater)),
    "GreaterOrEqual": _plain(choice.comparison(np.greater_equal)),
    "Identity": _plain(lambda x: x),
    "LSTM": lstm,
    "LeakyRelu": activations.leaky_relu,
    "Less": _plain(choice.comparison(np.less)),
    "LessOrEqual": _plain(choice.comparison(np.less_equal)),
    "MatMul": _mat_mul,
    "Log": _plain(functions.monotone(np.log, TINY)),
    "Max": _of_any_number(functions.larger),
    "Min": _of_any_number(functions.smaller),
    "Mod": choice.remainder,
    "Mul": _plain(multiply),
    "Neg": _plain(functions.negative),
    "Not": _plain(choice.inverse),
    "Or": _plain(choice.either),
    "Pow": _plain(functions.power),
    "ReduceMax": functions.extreme(np.max),
    "ReduceMean": functions.mean,
    "ReduceMin": functions.extreme(np.min),
    "ReduceSum": functions.total,
    "Relu": _plain(relu),
    "Sigmoid": _plain(sigmoid),
    "Sign": _plain(choice.sign),
    "Sin": _plain(functions.wave(np.sin)),
    "Softmax": activations.soft_max,
    "Softplus": _plain(activations.softplus),
    "Sqrt": _plain(square_root),
    "Sub": _plain(subtract),
    "Tanh": _plain(tanh),
    "Where": _plain(choice.chosen),
}
"""Name of an ONNX operator → its result with its error."""
_WINDOWS: dict[str, Error] = {
    "AveragePool": windows.mean,
    "Conv": windows.convolution,
    "MaxPool": windows.largest,
}
"""The same of what slides; it is given the reference's own operator."""
_KNOWN = {"ArgMax", *_MOVES, *_ERRORS, *_WINDOWS}
