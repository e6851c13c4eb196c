"""The order of the online learner's weights: one vector whose rows fill whole vector registers.

    W₁ᵀ (inputs, padded), b₁ (padded,), W₂ (actions, padded)

`padded` is the next multiple of 16 above the number of hidden units, and column h of each row
belongs to hidden unit h. The column after the last one belongs to a unit that is always 1: in W₂
it holds the biases b₂. All other columns stay 0. With rows of ten, the compiler would make scalar
instructions of the innermost loops.

Files and networks have the order of `policy/weights.py`, called plain here.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[Any]

_VECTOR = 16
"""Numbers of float32 in the widest vector register."""


class Matrices(NamedTuple):
    """Matrix views of a vector that has one number per weight."""

    first: Floats
    """W₁ᵀ: (inputs, padded)."""
    first_bias: Floats
    """b₁: (padded,)."""
    second: Floats
    """W₂, b₂, zeros: (actions, padded)."""


def padded(hidden: int) -> int:
    """Length of a row for so many hidden units."""
    return (hidden + _VECTOR) // _VECTOR * _VECTOR


def length(inputs: int, hidden: int, actions: int) -> int:
    """Length of the vector for a network of that size."""
    return (inputs + 1 + actions) * padded(hidden)


def matrices(vector: Floats, inputs: int, hidden: int) -> Matrices:
    """Views of the matrices in a vector."""
    rows = vector.reshape(-1, padded(hidden))
    return Matrices(rows[:inputs], rows[inputs], rows[inputs + 1 :])


def to_online(plain: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """Weights in this order, from the plain order: (parameters,) each."""
    vector = np.zeros(length(inputs, hidden, actions), plain.dtype)
    views, ends = matrices(vector, inputs, hidden), _plain_ends(inputs, hidden, actions)
    first, first_bias, second, second_bias = np.split(plain, ends)
    views.first[:, :hidden] = first.reshape(hidden, inputs).T
    views.first_bias[:hidden] = first_bias
    views.second[:, :hidden] = second.reshape(actions, hidden)
    views.second[:, hidden] = second_bias
    return vector


def from_online(vector: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """Weights in the plain order, from this order: (parameters,) each."""
    views = matrices(vector, inputs, hidden)
    first, second = views.first[:, :hidden].T, views.second[:, :hidden]
    biases = views.first_bias[:hidden], views.second[:, hidden]
    return np.concatenate([first.ravel(), biases[0], second.ravel(), biases[1]])


def _plain_ends(inputs: int, hidden: int, actions: int) -> list[int]:
    """Where W₁, b₁ and W₂ end in the plain order."""
    start = hidden * (inputs + 1)
    return [hidden * inputs, start, start + actions * hidden]
