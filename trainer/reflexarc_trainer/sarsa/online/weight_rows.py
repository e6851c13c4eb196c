"""How the online learner keeps its weights: one vector, cut so that its loops are whole vectors.

    W₁ᵀ (inputs, padded), b₁ (padded), W₂ (actions, padded)

`padded` is the next multiple of 16 above the hidden units: a column is a unit. Behind the hidden
ones is a unit that is always 1, whose column of W₂ is the biases; all else there stays 0. Loops of
ten would run one by one.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[Any]

_VECTOR = 16


class Matrices(NamedTuple):
    """A vector of weights, or of anything that there is one of for each weight, cut up."""

    first: Floats
    """Weights of the hidden units, zeros: (inputs, padded)."""
    first_bias: Floats
    """(padded,)."""
    second: Floats
    """Weights, bias, zeros: (actions, padded)."""


def padded(hidden: int) -> int:
    """Length of a row."""
    return (hidden + _VECTOR) // _VECTOR * _VECTOR


def length(inputs: int, hidden: int, actions: int) -> int:
    """Length of the vector."""
    return (inputs + 1 + actions) * padded(hidden)


def matrices(vector: Floats, inputs: int, hidden: int) -> Matrices:
    """The parts of a vector: views."""
    rows = vector.reshape(-1, padded(hidden))
    return Matrices(rows[:inputs], rows[inputs], rows[inputs + 1 :])


def to_online(plain: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """From the order of `weights.py`."""
    vector = np.zeros(length(inputs, hidden, actions), plain.dtype)
    here, ends = matrices(vector, inputs, hidden), _ends(inputs, hidden, actions)
    first, first_bias, second, second_bias = np.split(plain, ends)
    here.first[:, :hidden] = first.reshape(hidden, inputs).T
    here.first_bias[:hidden] = first_bias
    here.second[:, :hidden] = second.reshape(actions, hidden)
    here.second[:, hidden] = second_bias
    return vector


def from_online(vector: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """To the order of `weights.py`."""
    here = matrices(vector, inputs, hidden)
    first, second = here.first[:, :hidden].T, here.second[:, :hidden]
    biases = here.first_bias[:hidden], here.second[:, hidden]
    return np.concatenate([first.ravel(), biases[0], second.ravel(), biases[1]])


def _ends(inputs: int, hidden: int, actions: int) -> list[int]:
    """Where W₁, b₁ and W₂ end in the order of `weights.py`."""
    start = hidden * (inputs + 1)
    return [hidden * inputs, start, start + actions * hidden]
