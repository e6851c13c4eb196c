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
FREE = -1
"""In place of the action in force where there is none: in a new world, and after a contact."""
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
def greedy(
    q_values: npt.NDArray[Any], column: int, in_force: int, margin: float, least_lead: float
) -> int:
    """The winner, or the action in force where the winner leads it by too little.

    The rule of `reflexarc_runtime.choice`, by which the learned policy drives.

    Args:
        q_values: (actions, columns).
        column: of the agent.
        in_force: the action that was done last, or FREE.
        margin: least lead, as a share of the spread of the Q-values.
        least_lead: least lead, in their own unit.
    """
    best = winner(q_values, column)
    if in_force == FREE or (margin == 0.0 and least_lead == 0.0):
        return best
    worst = float(q_values[0, column])
    for action in range(1, q_values.shape[0]):
        worst = min(worst, float(q_values[action, column]))
    lead = float(q_values[best, column]) - float(q_values[in_force, column])
    spread = float(q_values[best, column]) - worst
    return best if lead >= margin * spread and lead >= least_lead else in_force


@compiled
def choose(
    q_values: npt.NDArray[Any],
    column: int,
    epsilon: float,
    streams: Streams,
    agent: int,
    in_force: int,
    margin: float,
    least_lead: float,
) -> int:
    """ε-greedy: with probability ε a uniformly random action, else that of `greedy`."""
    if uniform(streams, agent) < epsilon:
        return int(uniform(streams, agent) * q_values.shape[0])
    return greedy(q_values, column, in_force, margin, least_lead)


@compiled
def expected_value(
    q_values: npt.NDArray[Any], column: int, epsilon: float, greedy_action: int
) -> float:
    """Expectation of Q over the ε-greedy choice: (1 − ε) Q of the greedy action + ε mean Q."""
    total = 0.0
    for action in range(q_values.shape[0]):
        total += q_values[action, column]
    best: float = q_values[greedy_action, column]
    value: float = (1.0 - epsilon) * best + epsilon * total / q_values.shape[0]
    return value
