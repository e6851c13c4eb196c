"""Running errors of the recurrent ONNX nodes, built from those of their parts.

The formulas are those of `recurrent_operators.py` in the runtime.
"""

from typing import Any, TypeAlias

import numpy as np

from reflexarc_trainer.policy.rounding.running_error import (
    Array,
    Running,
    add,
    affine,
    exactly,
    multiply,
    rounding,
    side_by_side,
    sigmoid,
    tanh,
)

Parts: TypeAlias = tuple[list[Array], list[Array], list[Array], list[Array]]
"""W and R (inputs, size), and the biases of both (size,): one of each a gate."""


def gru(attributes: dict[str, Any], x: Running, *others: Any) -> tuple[Running, ...]:
    """Y and Y_h of a GRU node; `others` are W, R, B, sequence_lens, initial_h."""
    w, r, b, _, start = (*others, *[None] * 5)[:5]
    parts, h = _parts(3, w, r, b), _start(start, x, r)
    before_reset, every = bool(attributes.get("linear_before_reset", 0)), []
    for row in _rows(x):
        h = _gru_step(row, h, parts, before_reset)
        every.append(h)
    return _stacked(every), _as_row(h)


def lstm(_: dict[str, Any], x: Running, *others: Any) -> tuple[Running, ...]:
    """Y, Y_h and Y_c of an LSTM node; `others` are W, R, B, sequence_lens, initial_h, initial_c."""
    w, r, b, _lengths, h, c = (*others, *[None] * 6)[:6]
    parts, h, c = _parts(4, w, r, b), _start(h, x, r), _start(c, x, r)
    every = []
    for row in _rows(x):
        h, c = _lstm_step(row, h, c, parts)
        every.append(h)
    return _stacked(every), _as_row(h), _as_row(c)


def _gru_step(x: Running, h: Running, parts: Parts, before_reset: bool) -> Running:
    w, r, of_w, of_r = parts
    update, reset = (sigmoid(_gate(x, h, parts, gate)) for gate in range(2))
    if before_reset:
        recurrent = multiply(reset, affine(h, r[2], of_r[2]))
        new = tanh(add(affine(x, w[2], of_w[2]), recurrent))
    else:
        new = tanh(_gate(x, multiply(reset, h), parts, 2))
    return _mixed(update, new, h)


def _mixed(z: Running, n: Running, h: Running) -> Running:
    """(1 − z) n + z h, in whichever way it is written: none has more than five roundings."""
    value = (1.0 - z.value) * n.value + z.value * h.value
    error = (1.0 - z.value) * n.error + z.value * h.error
    error = error + z.error * (np.abs(h.value - n.value) + n.error + h.error)
    return Running(value, error + rounding(np.maximum(n.size, h.size), 5))


def _lstm_step(x: Running, h: Running, c: Running, parts: Parts) -> tuple[Running, Running]:
    sums = [_gate(x, h, parts, gate) for gate in range(4)]
    enter, leave, keep = map(sigmoid, sums[:3])
    c = add(multiply(keep, c), multiply(enter, tanh(sums[3])))
    return multiply(leave, tanh(c)), c


def _gate(x: Running, h: Running, parts: Parts, gate: int) -> Running:
    """The sum that goes into a gate, of everything at once: no order is known."""
    w, r, of_w, of_r = (part[gate] for part in parts)
    return affine(side_by_side(x, h), np.concatenate([w, r]), of_w, of_r)


def _parts(gates: int, w: Running, r: Running, b: Running | None) -> Parts:
    biases = np.zeros((1, 2 * gates * r.value.shape[2])) if b is None else b.value
    of_w, of_r = np.split(biases[0], 2)
    inputs, recurrent = ([rows.T for rows in np.split(part.value[0], gates)] for part in (w, r))
    return inputs, recurrent, np.split(of_w, gates), np.split(of_r, gates)


def _start(start: Running | None, x: Running, r: Running) -> Running:
    if start is None:
        return exactly(np.zeros((x.value.shape[1], r.value.shape[2])))
    return start.map(lambda part: part[0])


def _rows(x: Running) -> list[Running]:
    return [Running(*row) for row in zip(x.value, x.error, strict=True)]


def _stacked(rows: list[Running]) -> Running:
    """(steps, 1, n, size) of the h of every step."""
    value, error = (np.stack([getattr(h, part) for h in rows]) for part in ("value", "error"))
    return Running(value[:, np.newaxis], error[:, np.newaxis])


def _as_row(h: Running) -> Running:
    return h.map(lambda part: part[np.newaxis])
