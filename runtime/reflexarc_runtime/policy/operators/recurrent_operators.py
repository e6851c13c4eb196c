"""The recurrent ONNX operators that the NumPy backend has: GRU, LSTM and RNN.

Shapes, as in the ONNX specification (operator set 17, layout 0, one direction):

    X (steps, n, inputs)     W (1, gates·size, inputs)   R (1, gates·size, size)
    B (1, 2·gates·size): the biases of W, then those of R
    initial_h, initial_c (1, n, size)  →  Y (steps, 1, n, size), Y_h, Y_c (1, n, size)

Gates lie in the order z r h (GRU: update, reset, hidden) and i o f c (LSTM: input, output, forget,
cell). With σ the sigmoid and ∘ the product of elements:

    GRU   z = σ(Wz x + Rz h)   r = σ(Wr x + Rr h)   h' = (1 − z) ∘ n + z ∘ h
          n = tanh(Wh x + Rh (r ∘ h)),  or tanh(Wh x + r ∘ (Rh h)) with linear_before_reset
    RNN   h' = tanh(W x + R h), or with ReLU
    LSTM  i, o, f = σ(W x + R h)   g = tanh(Wc x + Rc h)   c' = f ∘ c + i ∘ g   h' = o ∘ tanh(c')
"""

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.activation_operators import sigmoid
from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor

Step: TypeAlias = Callable[[Tensor, tuple[Tensor, ...]], tuple[Tensor, ...]]
"""(the inputs' part of the gates, what is remembered) → what is remembered next; h comes first."""

_ACTIVATIONS = {
    "GRU": ((b"sigmoid", b"tanh"),),
    "LSTM": ((b"sigmoid", b"tanh", b"tanh"),),
    "RNN": ((b"tanh",), (b"relu",)),
}
"""Those that are computed; the first are the default."""
_KNOWN = {
    "activations",
    "direction",
    "hidden_size",
    "input_forget",
    "layout",
    "linear_before_reset",
}


def _gru(node: OnnxNode) -> Operator:
    _check_recurrent(node)
    before_reset = bool(node.get("linear_before_reset", 0))

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


def _lstm(node: OnnxNode) -> Operator:
    _check_recurrent(node)

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


def _rnn(node: OnnxNode) -> Operator:
    _check_recurrent(node)
    bend = np.tanh if _activations(node) == (b"tanh",) else lambda x: np.maximum(x, 0.0)

    def rnn(
        x: Tensor,
        w: Tensor,
        r: Tensor,
        b: Tensor | None = None,
        _: None = None,
        initial_h: Tensor | None = None,
    ) -> tuple[Tensor, ...]:
        of_w, of_r = _biases(b, r.shape[2])

        def step(inputs: Tensor, memory: tuple[Tensor, ...]) -> tuple[Tensor, ...]:
            return (bend(inputs + (memory[0] @ r[0].T + of_r)),)

        return _run(step, x @ w[0].T + of_w, (_start(initial_h, x, r.shape[2]),))

    return rnn


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


def _check_recurrent(node: OnnxNode) -> None:
    node.passes_over(*_KNOWN)
    for reason in _unsupported(node):
        raise PolicyError(
            f"operator {node.kind} (node {node.name!r}): {reason} is not in "
            "the NumPy backend; use --backend onnxruntime"
        )


def _unsupported(node: OnnxNode) -> Iterator[str]:
    """What a node asks for that the functions above do not compute, by name."""
    direction = node.word("direction", "forward")
    if direction != "forward":
        yield f"direction={direction}"
    if node.get("layout", 0):
        yield f"layout={node['layout']}"
    if node.get("input_forget", 0):
        yield "input_forget=1"
    if _activations(node) not in _ACTIVATIONS[node.kind]:
        yield f"activations={b' '.join(node['activations']).decode(errors='replace')[:60]}"
    yield from sorted(node.attributes.keys() - _KNOWN)
    for index, name in ((4, "sequence_lens"), (7, "P (peepholes)")):
        if len(node.inputs) > index and node.inputs[index]:
            yield f"input {name}"


def _activations(node: OnnxNode) -> tuple[bytes, ...]:
    usual = _ACTIVATIONS[node.kind][0]
    return tuple(name.lower() for name in node.get("activations", usual))


RECURRENT: dict[str, Maker] = {"GRU": _gru, "LSTM": _lstm, "RNN": _rnn}
"""Name of an ONNX operator → what makes its function from a node."""
