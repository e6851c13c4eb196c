"""What the online learner carries from step to step, and the buffers of one step."""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.sarsa.exploration import Streams
from reflexarc_trainer.sarsa.online.weight_rows import Matrices, matrices

_VECTOR = 8

Floats = npt.NDArray[Any]
"""Of the learner's precision."""
Bytes = npt.NDArray[np.uint8]


class Rules(NamedTuple):
    """What stays the same over a run: the learner's constants."""

    hidden: int
    """Number of hidden units."""
    units: int
    """Code of the hidden units."""
    output: int
    """Code of the output units."""
    step: int
    """Code of the step rule."""
    alpha: float
    alpha_end: float
    """α at the end of the run."""
    kappa: float
    steps: float
    """Length of the run."""
    gamma: float
    trace_decay: float
    expected: bool
    reward_step: float
    reward_contact: float
    centring: float
    averaging: float
    terminal: bool
    epsilon_start: float
    epsilon_end: float
    epsilon_steps: float
    held_actions: int
    action_repeat: int
    """Steps of the world an action."""


class LearnerState(NamedTuple):
    """What changes from step to step."""

    weights: Floats
    """(parameters,)"""
    averaged: Floats
    """Average of the weights over the updates; not kept up without averaging: (parameters,)."""
    trace: Floats
    """(parameters,)"""
    squares: Floats
    """Running mean of the squares of the gradients (intentional step) or of δe (rmsprop):
    (parameters,)."""
    scales: Floats
    """1 / RMS(δe) as last taken, for the step by RMS: (parameters,)."""
    inputs: Floats
    """What the agent sees where it stands, as the network takes it: (inputs,)."""
    pending: npt.NDArray[np.int64]
    """The action chosen for the next step, the steps for which it is still held, the number of
    steps done: (3,)."""
    streams: Streams
    """Exploration: (1,)."""
    running: npt.NDArray[np.float64]
    """Average reward, mean square of δ: (2,)."""
    totals: npt.NDArray[np.float64]
    """Σ|δ| since the last report; at it contacts, transitions and distance_m: (4,)."""


class Scratch(NamedTuple):
    """Views of the weights, and buffers of one step; nothing in the latter outlives it."""

    weights: Matrices
    """The weights of the state as matrices: the same memory."""
    gradient: Floats
    """∇Q(s, a): (parameters,)."""
    gradients: Matrices
    """The same memory as matrices."""
    curve: Floats
    """What the network sees of each byte: (256,)."""
    inputs: Floats
    """Of the place where the agent stood, and of the next: (2, inputs); so the two below."""
    hidden: Floats
    """Hidden units, the constant 1, zeros: (2, padded)."""
    q_values: Floats
    """Values of the actions, and what fills up the vector: (2, padded)."""
    choices: Floats
    """Those in the next place as choices: the same memory: (actions, 1)."""
    back: Floats
    """∂Q/∂(weighted sum of each hidden unit): (padded,)."""
    slope: Floats
    """∂Q/∂(weighted sum of the chosen action's unit): (1,)."""
    met: npt.NDArray[np.bool_]
    """Whether the step ended in a contact: (1,)."""


def new_state(weights: Floats, inputs: int, streams: Streams) -> LearnerState:
    """The state before the first step; `begin` looks and chooses.

    Args:
        weights: in the order of `online_weights`.
        inputs: how many.
        streams: the exploration's: (1,).
    """
    return LearnerState(
        weights=weights.copy(),
        averaged=weights.copy(),
        trace=np.zeros_like(weights),
        squares=np.zeros_like(weights),
        scales=np.zeros_like(weights),
        inputs=np.zeros(inputs, weights.dtype),
        pending=np.zeros(3, np.int64),
        streams=streams.copy(),
        running=np.zeros(2),
        totals=np.zeros(4),
    )


def new_scratch(state: LearnerState, hidden: int, actions: int, curve: Floats) -> Scratch:
    """Views and buffers for a state."""
    inputs, gradient = len(state.inputs), np.zeros_like(state.weights)
    views = matrices(state.weights, inputs, hidden)
    padded = views.second.shape[1]
    dtype = state.weights.dtype
    q_values = np.zeros((2, math.ceil(actions / _VECTOR) * _VECTOR), dtype)
    return Scratch(
        weights=views,
        gradient=gradient,
        gradients=matrices(gradient, inputs, hidden),
        curve=curve,
        inputs=np.zeros((2, inputs), dtype),
        hidden=np.zeros((2, padded), dtype),
        q_values=q_values,
        choices=q_values[1, :actions, np.newaxis],
        back=np.zeros(padded, dtype),
        slope=np.zeros(1, dtype),
        met=np.zeros(1, np.bool_),
    )
