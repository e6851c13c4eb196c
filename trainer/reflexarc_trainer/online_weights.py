"""How the online learner keeps its weights: one vector, cut so that its loops are whole vectors.

    W₁ (hidden, inputs), b₁ (hidden), W₂ (actions, padded)

`padded` is the next multiple of 16 above the hidden units: one column of W₂ more is the biases,
behind a unit that is always 1, and the rest stays 0. Loops of ten would run one by one.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_VECTOR = 16


class Matrices(NamedTuple):
    """A vector of weights, or of anything that there is one of for each weight, cut up."""

    first: Floats
    """(hidden, inputs)."""
    first_bias: Floats
    """(hidden,)."""
    second: Floats
    """Weights, bias, zeros: (actions, padded)."""


def padded(hidden: int) -> int:
    """Length of a row of W₂."""
    return (hidden + _VECTOR) // _VECTOR * _VECTOR


def length(inputs: int, hidden: int, actions: int) -> int:
    """Length of the vector."""
    return (inputs + 1) * hidden + actions * padded(hidden)


def matrices(vector: Floats, inputs: int, hidden: int, actions: int) -> Matrices:
    """The parts of a vector: views."""
    first, bias, second = np.split(vector, [hidden * inputs, hidden * (inputs + 1)])
    return Matrices(first.reshape(hidden, inputs), bias, second.reshape(actions, -1))


def to_online(plain: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """From the order of `weights.py`."""
    vector = np.zeros(length(inputs, hidden, actions))
    here = matrices(vector, inputs, hidden, actions)
    start = hidden * (inputs + 1)
    vector[:start] = plain[:start]
    here.second[:, :hidden] = plain[start:-actions].reshape(actions, hidden)
    here.second[:, hidden] = plain[-actions:]
    return vector


def from_online(vector: Floats, inputs: int, hidden: int, actions: int) -> Floats:
    """To the order of `weights.py`."""
    here = matrices(vector, inputs, hidden, actions)
    second, bias = here.second[:, :hidden], here.second[:, hidden]
    return np.concatenate([vector[: hidden * (inputs + 1)], second.ravel(), bias])
