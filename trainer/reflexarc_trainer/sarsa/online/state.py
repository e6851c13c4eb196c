"""Memory of the online learner: a run's constants, what changes, and the buffers of one update.

Compiled code is given these tuples of numbers and arrays. Single numbers that change are fields of
one structured row, `PROGRESS_DTYPE`; a checkpoint carries every array of `LearnerState`.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.sarsa.exploration import Streams
from reflexarc_trainer.sarsa.online.weight_rows import Matrices, matrices

NOW, NEXT = 0, 1
"""First index of the buffers that hold two states: s, and s′ to which the action has led."""

_VECTOR = 8
"""Q-values are filled up with zeros to a multiple of this length."""

Floats = npt.NDArray[Any]
"""float32 or float64, as `learner.online.precision` says."""
Bytes = npt.NDArray[np.uint8]

PROGRESS_DTYPE = np.dtype(
    [
        # Further transitions for which the pending action is held.
        ("held_actions", np.int64),
        # Transitions learned from so far.
        ("step", np.int64),
        # Running averages: of the reward, and of δ² (for the intentional step).
        ("average_reward", np.float64),
        ("mean_square", np.float64),
        # Σ|δ| since the last report.
        ("sum_abs_error", np.float64),
    ],
    align=True,
)
"""The single numbers that change from transition to transition."""


class Rules(NamedTuple):
    """The constants of a run; the configuration documents those without a docstring here."""

    hidden: int
    """Number of hidden units."""
    units: int
    """Kind of the hidden units: a code of `units.py`."""
    output: int
    """Kind of the output units."""
    step: int
    """Step rule: a code of `traces.py`."""
    alpha: float
    alpha_end: float
    """α at the end of the run."""
    kappa: float
    steps: float
    """Transitions of the whole run."""
    gamma: float
    trace_decay: float
    expected: bool
    """Whether the target takes the expectation over a′ in place of Q(s′, a′)."""
    reward_step: float
    reward_contact: float
    centring: float
    """`learner.reward_centring`."""
    averaging: float
    """`learner.averaged_weights`."""
    terminal: bool
    """Whether the value of s′ counts as 0 after a contact."""
    epsilon_start: float
    epsilon_end: float
    epsilon_steps: float
    """Transitions over which ε decays."""
    held_actions: int
    action_repeat: int
    """World steps per transition."""
    margin: float
    least_lead: float
    reward_switch: float


class LearnerState(NamedTuple):
    """Everything that changes from transition to transition."""

    weights: Floats
    """w, in the order of `weight_rows.py`, as all arrays of this length: (parameters,)."""
    averaged: Floats
    """Average of w over the updates; w at the start where averaging is off: (parameters,)."""
    trace: Floats
    """e: (parameters,)."""
    squares: Floats
    """Running mean of (∇Q)² (intentional step) or of (δe)² (step by RMS): (parameters,)."""
    scales: Floats
    """1 / RMS(δe) as it was last computed, for the step by RMS: (parameters,)."""
    inputs: Floats
    """What the network sees of the state s: (inputs,)."""
    action: npt.NDArray[np.int64]
    """The action chosen for s; an array, for the world reads it at its address: (1,)."""
    progress: npt.NDArray[np.void]
    """`PROGRESS_DTYPE`: (1,)."""
    streams: Streams
    """Random stream of the exploration: (1,)."""


class Scratch(NamedTuple):
    """Views of the weights, and buffers that every update fills anew."""

    weights: Matrices
    """The state's weights as matrices: the same memory."""
    gradient: Floats
    """∇Q(s, a): (parameters,)."""
    gradients: Matrices
    """The gradient as matrices: the same memory."""
    curve: Floats
    """What the network sees of each byte: (256,)."""
    inputs: Floats
    """Of s and s′: (2, inputs)."""
    hidden: Floats
    """Activations of the hidden units, the constant 1, zeros; of s and s′: (2, padded)."""
    q_values: Floats
    """Q-values, zeros; of s and s′: (2, padded)."""
    choices: Floats
    """Q(s′, ·) as the exploration takes it, the same memory: (actions, 1)."""
    back: Floats
    """∂Q(s, a) / ∂(weighted sum of each hidden unit): (padded,)."""
    slope: Floats
    """∂Q(s, a) / ∂(weighted sum of the output unit of a): (1,)."""
    met: npt.NDArray[np.bool_]
    """Whether the last world step ended in a contact: (1,)."""


def new_state(weights: Floats, inputs: int, streams: Streams) -> LearnerState:
    """The state before the first transition, with no action chosen: `update.begin` chooses one.

    Args:
        weights: in the order of `weight_rows.py`: (parameters,).
        inputs: number of inputs.
        streams: of the exploration: (1,).
    """
    return LearnerState(
        weights=weights.copy(),
        averaged=weights.copy(),
        trace=np.zeros_like(weights),
        squares=np.zeros_like(weights),
        scales=np.zeros_like(weights),
        inputs=np.zeros(inputs, weights.dtype),
        action=np.zeros(1, np.int64),
        progress=np.zeros(1, PROGRESS_DTYPE),
        streams=streams.copy(),
    )


def new_scratch(state: LearnerState, hidden: int, actions: int, curve: Floats) -> Scratch:
    """Views and buffers for a state; `curve` is that of `network_shape.input_curve`: (256,)."""
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
        choices=q_values[NEXT, :actions, np.newaxis],
        back=np.zeros(padded, dtype),
        slope=np.zeros(1, dtype),
        met=np.zeros(1, np.bool_),
    )
