"""Choosing actions while learning: ε-greedy, from a random stream that lives in an array.

The stream is splitmix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators",
2014): its whole state is one uint64, so a checkpoint carries it and a resumed run draws the same
numbers. Compiled, and callable from plain Python as well.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.compiled import compiled

Stream = npt.NDArray[np.uint64]
"""State of a random stream: (1,)."""

_INCREMENT = np.uint64(0x9E3779B97F4A7C15)
_FACTORS = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
_SHIFTS = (np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11))
_UNIT = 2.0**-53


def new_stream(seed: int) -> Stream:
    """The stream of a seed."""
    words = np.random.SeedSequence([seed, _STREAM_TAG]).generate_state(1, np.uint64)
    return words.astype(np.uint64)


@compiled
def uniform(stream: Stream) -> float:
    """The next number of the stream, uniform in [0, 1)."""
    stream[0] += _INCREMENT
    z = stream[0]
    z = (z ^ (z >> _SHIFTS[0])) * _FACTORS[0]
    z = (z ^ (z >> _SHIFTS[1])) * _FACTORS[1]
    z = z ^ (z >> _SHIFTS[2])
    return float(z >> _SHIFTS[3]) * _UNIT


@compiled
def winner(q_values: npt.NDArray[np.float64]) -> int:
    """Winner takes all; of equal values the first wins."""
    best = 0
    for action in range(1, len(q_values)):
        if q_values[action] > q_values[best]:
            best = action
    return best


@compiled
def choose(q_values: npt.NDArray[np.float64], epsilon: float, stream: Stream) -> int:
    """With probability ε any action, else the winner."""
    if uniform(stream) < epsilon:
        return int(uniform(stream) * len(q_values))
    return winner(q_values)


_STREAM_TAG = 0x45585052
"""Keeps the exploration apart from every other stream of the same seed."""
