"""ε-greedy choice of actions while learning, from random streams that live in an array.

A stream is splitmix64 (Steele, Lea & Flood, "Fast splittable pseudorandom number generators",
2014). Its whole state is one uint64; a checkpoint carries it, so that a resumed run draws the same
numbers. Each agent has a stream of its own: what it draws depends neither on other agents nor on
threads. The functions are compiled, and Python can call them as well.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import compiled

Streams = npt.NDArray[np.uint64]
"""States of random streams, one an agent: (agents,)."""

_INCREMENT = np.uint64(0x9E3779B97F4A7C15)
_FACTORS = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
_SHIFTS = (np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11))
_UNIT = 2.0**-53
"""Makes a number in [0, 1) of the upper 53 bits."""
_STREAM_TAG = 0x45585052
"""Keeps the exploration's streams apart from all others of the same seed ("EXPR" in ASCII)."""


def new_streams(seed: int, agents: int = 1) -> Streams:
    """The streams of a seed, one per agent: (agents,)."""
    words = np.random.SeedSequence([seed, _STREAM_TAG]).generate_state(agents, np.uint64)
    return words.astype(np.uint64)


@compiled
def uniform(streams: Streams, agent: int) -> float:
    """The next number of an agent's stream, uniform in [0, 1)."""
    streams[agent] += _INCREMENT
    z = streams[agent]
    z = (z ^ (z >> _SHIFTS[0])) * _FACTORS[0]
    z = (z ^ (z >> _SHIFTS[1])) * _FACTORS[1]
    z = z ^ (z >> _SHIFTS[2])
    return float(z >> _SHIFTS[3]) * _UNIT


@compiled
def winner(q_values: npt.NDArray[Any], column: int) -> int:
    """The greedy action of a column of Q-values (actions, columns); of equal ones the first."""
    best = 0
    for action in range(1, q_values.shape[0]):
        if q_values[action, column] > q_values[best, column]:
            best = action
    return best


@compiled
def choose(
    q_values: npt.NDArray[Any], column: int, epsilon: float, streams: Streams, agent: int
) -> int:
    """ε-greedy: with probability ε a uniformly random action, else the greedy one."""
    if uniform(streams, agent) < epsilon:
        return int(uniform(streams, agent) * q_values.shape[0])
    return winner(q_values, column)


@compiled
def expected_value(q_values: npt.NDArray[Any], column: int, epsilon: float) -> float:
    """Expectation of Q over the ε-greedy choice: (1 − ε) max Q + ε mean Q."""
    total = 0.0
    for action in range(q_values.shape[0]):
        total += q_values[action, column]
    best: float = q_values[winner(q_values, column), column]
    value: float = (1.0 - epsilon) * best + epsilon * total / q_values.shape[0]
    return value
