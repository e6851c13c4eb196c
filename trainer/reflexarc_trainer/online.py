r"""SARSA(λ), compiled: the same algorithm as `reference.py`, a thousand times as fast.

One agent, one update a step, float64, no fast maths (it would break the checks for finite values).
The network is one flat vector of weights; a bias is the weight of a constant input 1, so with I
inputs, H hidden units and A actions the vector holds

    W₁ as (I + 1, H) rows, then W₂ as (A, H + 1) rows.

Rows of W₁ run over the hidden units, so that the innermost loops are vectors. Everything that a
run needs to go on lies in `LearnerState`, which a checkpoint carries.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.retina import FULL_SCALE
from reflexarc_sim_bridge.compiled import compiled
from reflexarc_trainer import schedules
from reflexarc_trainer.choice import Stream, choose

Floats = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.uint8]

linear_epsilon = compiled(schedules.linear_epsilon)


class Rules(NamedTuple):
    """What stays the same over a run: sizes, and the learner's constants."""

    inputs: int
    hidden: int
    actions: int
    sigmoid_output: bool
    alpha: float
    gamma: float
    trace_decay: float
    literal: bool
    kappa: float
    reward_step: float
    reward_contact: float
    terminal: bool
    epsilon_start: float
    epsilon_end: float
    epsilon_steps: float
    held_actions: int

    @property
    def parameters(self) -> int:
        """Number of weights."""
        return (self.inputs + 1) * self.hidden + self.actions * (self.hidden + 1)


class LearnerState(NamedTuple):
    """What changes from step to step."""

    weights: Floats
    """(parameters,)"""
    trace: Floats
    """(parameters,)"""
    inputs: Floats
    """What the agent sees where it stands, in [0, 1], then the constant 1: (inputs + 1,)."""
    pending: npt.NDArray[np.int64]
    """The action chosen for the next step, the steps for which it is still held, the number of
    steps done: (3,)."""
    stream: Stream
    """Exploration: (1,)."""
    totals: Floats
    """Since the last report Σ|δ| and contacts; at it the steps done and the distance_m: (4,)."""


class Scratch(NamedTuple):
    """Buffers of one step; nothing in them outlives it."""

    retina: Bytes
    """(inputs,)"""
    inputs: Floats
    """(inputs + 1,)"""
    hidden: Floats
    """Activations of the hidden units, then the constant 1: (hidden + 1,)."""
    back: Floats
    """∂Q/∂(weighted sum of each hidden unit): (hidden,)."""
    q_values: Floats
    """(actions,)"""


def new_state(rules: Rules, weights: Floats, stream: Stream) -> LearnerState:
    """The state before the first step; `begin` looks and chooses."""
    return LearnerState(
        weights=weights.astype(np.float64),
        trace=np.zeros(rules.parameters),
        inputs=np.ones(rules.inputs + 1),
        pending=np.zeros(3, np.int64),
        stream=stream.copy(),
        totals=np.zeros(4),
    )


def new_scratch(rules: Rules) -> Scratch:
    """Buffers of the right sizes."""
    return Scratch(
        retina=np.zeros(rules.inputs, np.uint8),
        inputs=np.ones(rules.inputs + 1),
        hidden=np.ones(rules.hidden + 1),
        back=np.zeros(rules.hidden),
        q_values=np.zeros(rules.actions),
    )


@compiled
def begin(rules: Rules, state: LearnerState, scratch: Scratch) -> None:
    """Choose the first action for the retina in `scratch`."""
    see(scratch.retina, scratch.inputs)
    forward(rules, state.weights, scratch.inputs, scratch.hidden, scratch.q_values)
    state.pending[0] = _next_action(rules, state, scratch.q_values, 0, True)
    state.inputs[:] = scratch.inputs


@compiled
def learn_step(rules: Rules, state: LearnerState, scratch: Scratch, contact: bool) -> float:
    """One transition: the pending action was done and led to the retina in `scratch`.

    Returns:
        The TD error δ.
    """
    action, step = state.pending[0], state.pending[2] + 1
    see(scratch.retina, scratch.inputs)
    forward(rules, state.weights, scratch.inputs, scratch.hidden, scratch.q_values)
    next_action = _next_action(rules, state, scratch.q_values, step, contact)
    target = rules.reward_contact if contact else rules.reward_step
    if not (contact and rules.terminal):
        target += rules.gamma * scratch.q_values[next_action]
    forward(rules, state.weights, state.inputs, scratch.hidden, scratch.q_values)
    td_error: float = target - scratch.q_values[action]
    add_gradient(rules, state, scratch, action)
    take_step(rules, state.weights, state.trace, td_error)
    if contact:
        state.trace[:] = 0.0
    state.inputs[:] = scratch.inputs
    state.pending[0], state.pending[2] = next_action, step
    state.totals[0] += abs(td_error)
    state.totals[1] += 1.0 if contact else 0.0
    return td_error


@compiled
def see(retina: Bytes, inputs: Floats) -> None:
    """Bytes to inputs in [0, 1]; the constant after them stays."""
    for i in range(len(retina)):
        inputs[i] = retina[i] / FULL_SCALE


@compiled
def forward(rules: Rules, weights: Floats, inputs: Floats, hidden: Floats, q: Floats) -> None:
    """Fill `hidden` and `q` for `inputs`."""
    width = rules.hidden
    hidden[:width] = 0.0
    for i in range(rules.inputs + 1):
        row, x = i * width, inputs[i]
        for h in range(width):
            hidden[h] += x * weights[row + h]
    for h in range(width):
        hidden[h] = _sigmoid(hidden[h])
    for a in range(rules.actions):
        row = (rules.inputs + 1) * width + a * (width + 1)
        total = 0.0
        for h in range(width + 1):
            total += hidden[h] * weights[row + h]
        q[a] = _sigmoid(total) if rules.sigmoid_output else total


@compiled
def add_gradient(rules: Rules, state: LearnerState, scratch: Scratch, action: int) -> None:
    """Add to the trace: e ← γλe + ∇Q(s, a), where `forward` has just filled the buffers for s."""
    width, trace = rules.hidden, state.trace
    decay = rules.gamma * rules.trace_decay
    first = (rules.inputs + 1) * width
    chosen = first + action * (width + 1)
    q = scratch.q_values[action]
    slope = q * (1.0 - q) if rules.sigmoid_output else 1.0
    for h in range(width):
        unit = scratch.hidden[h]
        scratch.back[h] = slope * state.weights[chosen + h] * unit * (1.0 - unit)
    for i in range(rules.inputs + 1):
        row, x = i * width, state.inputs[i]
        for h in range(width):
            trace[row + h] = decay * trace[row + h] + x * scratch.back[h]
    for k in range(first, len(trace)):
        trace[k] *= decay
    for h in range(width + 1):
        trace[chosen + h] += slope * scratch.hidden[h]


@compiled
def take_step(rules: Rules, weights: Floats, trace: Floats, td_error: float) -> None:
    """Change the weights: w ← w + step · δ · e."""
    change = step_size(rules, trace, td_error) * td_error
    for k in range(len(weights)):
        weights[k] += change * trace[k]


@compiled
def step_size(rules: Rules, trace: Floats, td_error: float) -> float:
    """α, or the bounded step min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁))."""
    if rules.literal:
        return rules.alpha
    bound = rules.kappa * max(1.0, abs(td_error)) * _norm(trace)
    return min(rules.alpha, 1.0 / bound) if bound > 0.0 else rules.alpha


@compiled
def _next_action(rules: Rules, state: LearnerState, q: Floats, step: int, contact: bool) -> int:
    """ε-greedy, unless the pending action is still held."""
    if state.pending[1] > 0 and not contact:
        state.pending[1] -= 1
        return int(state.pending[0])
    state.pending[1] = rules.held_actions - 1
    epsilon = linear_epsilon(step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps)
    return choose(q, epsilon, state.stream)


@compiled
def _norm(trace: Floats) -> float:
    """‖e‖₁ in four running sums: one would wait for itself at every addition."""
    a = b = c = d = 0.0
    whole = len(trace) // 4 * 4
    for k in range(0, whole, 4):
        a += abs(trace[k])
        b += abs(trace[k + 1])
        c += abs(trace[k + 2])
        d += abs(trace[k + 3])
    for k in range(whole, len(trace)):
        a += abs(trace[k])
    return (a + b) + (c + d)


@compiled
def _sigmoid(x: float) -> float:
    """σ(x), without overflow for any x."""
    tail = math.exp(-abs(x))
    return (1.0 if x >= 0.0 else tail) / (1.0 + tail)
