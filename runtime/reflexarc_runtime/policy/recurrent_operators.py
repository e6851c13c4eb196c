"""The ONNX operators of several outputs that the NumPy backend has: GRU, LSTM and Split.

Shapes, as in the ONNX specification (operator set 17, layout 0, one direction):

    X (steps, n, inputs)     W (1, gates·size, inputs)   R (1, gates·size, size)
    B (1, 2·gates·size): the biases of W, then those of R
    initial_h, initial_c (1, n, size)  →  Y (steps, 1, n, size), Y_h, Y_c (1, n, size)

Gates lie in the order z r h (GRU: update, reset, hidden) and i o f c (LSTM: input, output, forget,
cell). With σ the sigmoid and ∘ the product of elements:

    GRU   z = σ(Wz x + Rz h)   r = σ(Wr x + Rr h)   h' = (1 − z) ∘ n + z ∘ h
          n = tanh(Wh x + Rh (r ∘ h)),  or tanh(Wh x + r ∘ (Rh h)) with linear_before_reset
    LSTM  i, o, f = σ(W x + R h)   g = tanh(Wc x + Rc h)   c' = f ∘ c + i ∘ g   h' = o ∘ tanh(c')
"""

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
import onnx

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operator import Attributes, Tensor
from reflexarc_runtime.policy.operators import sigmoid

ManyOperator: TypeAlias = Callable[..., tuple[Tensor, ...]]
Step: TypeAlias = Callable[[Tensor, tuple[Tensor, ...]], tuple[Tensor, ...]]
"""(the inputs' part of the gates, what is remembered) → what is remembered next; h comes first."""

_ACTIVATIONS = {
    "GRU": (b"sigmoid", b"tanh"),
    "LSTM": (b"sigmoid", b"tanh", b"tanh"),
}
_KNOWN = {
    "activations",
    "direction",
    "hidden_size",
    "input_forget",
    "layout",
    "linear_before_reset",
}


def _gru(attributes: Attributes, node: onnx.NodeProto) -> ManyOperator:
    _check_recurrent(attributes, node)
    before_reset = bool(attributes.get("linear_before_reset", 0))

    def gru(
        x: Tensor,
        w: Tensor,
        r: Tensor,
        b: Tensor | None = None,
        _: None = None,
        initial_h: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        size = r.shape[2]
        of_w, of_r = _biases(b, 3 * size)
        step = _gru_step(r[0], of_r, size, before_reset)
        return _run(step, x @ w[0].T + of_w, (_start(initial_h, x, size),))

    return gru


def _gru_step(r: Tensor, bias: Tensor, size: int, before_reset: bool) -> Step:
    def step(inputs: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        (h,) = memory
        gates = sigmoid(inputs[:, : 2 * size] + (h @ r[: 2 * size].T + bias[: 2 * size]))
        update, reset = gates[:, :size], gates[:, size:]
        if before_reset:
            recurrent = reset * (h @ r[2 * size :].T + bias[2 * size :])
        else:
            recurrent = (reset * h) @ r[2 * size :].T + bias[2 * size :]
        new = np.tanh(inputs[:, 2 * size :] + recurrent)
        return ((1.0 - update) * new + update * h,)

    return step


def _lstm(attributes: Attributes, node: onnx.NodeProto) -> ManyOperator:
    _check_recurrent(attributes, node)

    def lstm(
        x: Tensor,
        w: Tensor,
        r: Tensor,
        b: Tensor | None = None,
        _: None = None,
        initial_h: Tensor | None = None,
        initial_c: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        size = r.shape[2]
        of_w, of_r = _biases(b, 4 * size)
        memory = (_start(initial_h, x, size), _start(initial_c, x, size))
        return _run(_lstm_step(r[0], of_r, size), x @ w[0].T + of_w, memory)

    return lstm


def _lstm_step(r: Tensor, bias: Tensor, size: int) -> Step:
    def step(inputs: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
        h, c = memory
        sums = inputs + (h @ r.T + bias)
        gates = sigmoid(sums[:, : 3 * size])
        enter, leave, keep = (gates[:, i * size : (i + 1) * size] for i in range(3))
        c = keep * c + enter * np.tanh(sums[:, 3 * size :])
        return leave * np.tanh(c), c

    return step


def _run(step: Step, inputs: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
    """Take all steps; the h of each, (steps, 1, n, size), and what is remembered in the end."""
    hidden = []
    for row in inputs:
        memory = step(row, memory)
        hidden.append(memory[0])
    return np.stack(hidden)[:, np.newaxis], *(part[np.newaxis] for part in memory)


def _biases(b: Tensor | None, gates: int) -> tuple[Tensor, Tensor]:
    b = np.zeros((1, 2 * gates)) if b is None else b
    return b[0, :gates], b[0, gates:]


def _start(initial: Tensor | None, x: Tensor, size: int) -> Tensor:
    start: Tensor = np.zeros((x.shape[1], size)) if initial is None else initial[0]
    return start


def _check_recurrent(attributes: Attributes, node: onnx.NodeProto) -> None:
    for reason in _unsupported(attributes, node):
        raise PolicyError(
            f"operator {node.op_type} (node {node.name or node.output[-1]!r}): {reason} is not in "
            "the NumPy backend; use --backend onnxruntime"
        )


def _unsupported(attributes: Attributes, node: onnx.NodeProto) -> Iterator[str]:
    """What a node asks for that the functions above do not compute, by name."""
    direction = attributes.get("direction", b"forward").decode()
    if direction != "forward":
        yield f"direction={direction}"
    if attributes.get("layout", 0):
        yield f"layout={attributes['layout']}"
    if attributes.get("input_forget", 0):
        yield "input_forget=1"
    usual = _ACTIVATIONS[node.op_type]
    activations = tuple(name.lower() for name in attributes.get("activations", usual))
    if activations != usual:
        yield f"activations={b' '.join(attributes['activations']).decode()}"
    yield from sorted(attributes.keys() - _KNOWN)
    for index, name in ((4, "sequence_lens"), (7, "P (peepholes)")):
        if len(node.input) > index and node.input[index]:
            yield f"input {name}"


def _split(attributes: Attributes, node: onnx.NodeProto) -> ManyOperator:
    axis, count = attributes.get("axis", 0), len(node.output)

    def split(x: Tensor, sizes: Tensor | None = None) -> tuple[Tensor, ...]:
        if sizes is None:
            # Parts of equal size, the last one smaller if need be.
            sizes = np.full(count, -(-x.shape[axis] // count))
        return tuple(np.split(x, np.cumsum(sizes)[:-1], axis))

    return split


MANY_OPERATORS: dict[str, Callable[[Attributes, onnx.NodeProto], ManyOperator]] = {
    "GRU": _gru,
    "LSTM": _lstm,
    "Split": _split,
}
"""Name of an ONNX operator → what makes its function from a node and its attributes."""
