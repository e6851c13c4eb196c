r"""SARSA(λ), compiled: the same algorithm as `reference.py`, thousands of times as fast.

One agent, one update a transition, one hidden layer. The weights are one flat vector in the
order of `online_weights.py`; what runs over all of them at once (trace, norm, update) is a single
long loop. Everything that a run needs to go on lies in `LearnerState`, which a checkpoint carries.
"""

from reflexarc_sim_bridge.native.decorators import (
    compiled,
    fused_disjoint,
    fused_free,
    fused_inline,
)
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_trainer.sarsa import schedules
from reflexarc_trainer.sarsa.exploration import choose, expected_value
from reflexarc_trainer.sarsa.online.row_products import dot, scale, weigh_two
from reflexarc_trainer.sarsa.online.state import (
    Bytes,
    Floats,
    LearnerState,
    Rules,
    Scratch,
)
from reflexarc_trainer.sarsa.online.traces import (
    BOUNDED,
    INTENTIONAL,
    RMSPROP,
    accumulate,
    bounded_step,
    cut_td_error,
    move,
    move_by_rms,
    move_intentionally,
    rescale,
)
from reflexarc_trainer.sarsa.step_rules import SCALED_AT_FIRST, SCALED_EVERY, SQUARES_KEPT
from reflexarc_trainer.sarsa.units import activate, times_slope

linear = compiled(schedules.linear)

_HERE, _THERE = 0, 1
"""Where the agent stood, and where its action has led."""

AVERAGED_EVERY = 16
"""The average over weights takes in those of every so many-th update, and lets them count for all.
"""
_LEAST_TENTH = 10.0
"""Early it reaches back over a tenth of the run so far: the first weights mean nothing."""


@fused_inline
def begin(rules: Rules, state: LearnerState, scratch: Scratch, retina: Bytes) -> None:
    """Choose the first action in a world for a retina (inputs,)."""
    _see(state, scratch, retina)
    forward(rules, scratch)
    step = state.pending[2]
    state.pending[0] = _next_action(rules, state, scratch.choices, step, True)
    _copy(scratch.inputs[_THERE], state.inputs)


@fused_inline
def learn_step(
    rules: Rules,
    state: LearnerState,
    scratch: Scratch,
    retina: Bytes,
    contact: bool,
    reward: float,
) -> float:
    """One transition: the pending action was done, brought `reward`, led to `retina` (inputs,).

    Returns:
        The TD error δ.
    """
    action, step = state.pending[0], state.pending[2] + 1
    _see(state, scratch, retina)
    forward(rules, scratch)
    next_action = _next_action(rules, state, scratch.choices, step, contact)
    target = _target(rules, state, scratch.choices, next_action, step, contact, reward)
    td_error: float = target - scratch.q_values[_HERE, action]
    fill_gradient(rules, scratch, action)
    take_step(rules, state, scratch.gradient, td_error, step)
    if contact:
        state.trace[:] = 0.0
    _copy(scratch.inputs[_THERE], state.inputs)
    state.pending[0], state.pending[2] = next_action, step
    state.totals[0] += abs(td_error)
    return td_error


@fused_inline
def forward(rules: Rules, scratch: Scratch) -> None:
    """Fill hidden units and values for the inputs, here and there.

    Both at once: one alone is a long chain of which each link waits for the one before.
    """
    weights, hidden, q = scratch.weights, scratch.hidden, scratch.q_values
    here, there = scratch.inputs[_HERE], scratch.inputs[_THERE]
    weigh_two(weights.first, weights.first_bias, here, there, hidden[_HERE], hidden[_THERE])
    activate(rules.units, hidden.reshape(hidden.size))
    for place in range(2):
        hidden[place, rules.hidden] = 1.0
        for h in range(rules.hidden + 1, hidden.shape[1]):
            hidden[place, h] = 0.0
    for a in range(len(weights.second)):
        q[_HERE, a] = dot(weights.second[a], hidden[_HERE])
        q[_THERE, a] = dot(weights.second[a], hidden[_THERE])
    activate(rules.output, q.reshape(q.size))


@fused_inline
def fill_gradient(rules: Rules, scratch: Scratch, action: int) -> None:
    """∇Q(s, a), where the agent stood; `forward` has just filled the buffers."""
    into, back, slope = scratch.gradients, scratch.back, scratch.slope
    inputs, hidden = scratch.inputs[_HERE], scratch.hidden[_HERE]
    slope[0] = 1.0
    times_slope(rules.output, scratch.q_values[_HERE, action : action + 1], slope)
    scale(slope[0], scratch.weights.second[action], back)
    times_slope(rules.units, hidden, back)
    back[rules.hidden] = 0.0
    for i in range(len(inputs)):
        scale(inputs[i], back, into.first[i])
    scale(1.0, back, into.first_bias)
    for a in range(len(into.second)):
        scale(slope[0] if a == action else 0.0, hidden, into.second[a])


@fused_inline
def take_step(
    rules: Rules, state: LearnerState, gradient: Floats, td_error: float, step: int
) -> None:
    """Move trace and weights at step number `step`, the first being 1."""
    alpha = linear(step - 1, rules.alpha, rules.alpha_end, rules.steps)
    norm = accumulate(state.trace, gradient, rules.gamma * rules.trace_decay)
    if rules.step == INTENTIONAL:
        square = td_error * td_error
        state.running[1] += (1.0 - SQUARES_KEPT) * (square - state.running[1])
        cut = cut_td_error(td_error, state.running[1], step)
        move_intentionally(state.weights, state.trace, state.squares, gradient, alpha * cut)
    elif rules.step == RMSPROP:
        trace, squares, scales = state.trace, state.squares, state.scales
        move_by_rms(state.weights, trace, squares, scales, td_error, alpha)
        if step <= SCALED_AT_FIRST or step % SCALED_EVERY == 0:
            rescale(squares, scales, 1.0 - SQUARES_KEPT**step)
    else:
        size = alpha
        if rules.step == BOUNDED:
            size = bounded_step(alpha, rules.kappa, td_error, norm)
        move(state.weights, state.trace, size * td_error)
    if rules.averaging > 0.0 and step % AVERAGED_EVERY == 0:
        _average(state.weights, state.averaged, averaged_share(rules.averaging, step))


@fused_inline
def _target(
    rules: Rules,
    state: LearnerState,
    q_values: Floats,
    action: int,
    step: int,
    contact: bool,
    reward: float,
) -> float:
    """The target r + γ V(s′), the reward centred; V is Q(s′, a′), or its expectation."""
    target: float = reward - rules.action_repeat * state.running[0]
    state.running[0] += rules.centring * (reward / rules.action_repeat - state.running[0])
    if contact and rules.terminal:
        return target
    if rules.expected:
        target += rules.gamma * expected_value(q_values, 0, _epsilon(rules, step))
    else:
        target += rules.gamma * q_values[action, 0]
    return target


@fused_inline
def _next_action(rules: Rules, state: LearnerState, q: Floats, step: int, contact: bool) -> int:
    """ε-greedy, unless the pending action is still held."""
    if state.pending[1] > 0 and not contact:
        state.pending[1] -= 1
        return int(state.pending[0])
    state.pending[1] = rules.held_actions - 1
    return choose(q, 0, _epsilon(rules, step), state.streams, 0)


@fused_inline
def _epsilon(rules: Rules, step: int) -> float:
    return linear(step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps)


@fused_inline
def _see(state: LearnerState, scratch: Scratch, retina: Bytes) -> None:
    here, there = scratch.inputs[_HERE], scratch.inputs[_THERE]
    _copy(state.inputs, here)
    for i in range(len(retina)):
        there[i] = scratch.curve[retina[i]]


@fused_inline
def _copy(source: Floats, target: Floats) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@fused_inline
def averaged_share(kept: float, step: int) -> float:
    """Share of the new weights in their average, which keeps `kept` of itself at each update."""
    taken = step / AVERAGED_EVERY
    return max(1.0 - kept**AVERAGED_EVERY, _LEAST_TENTH / (_LEAST_TENTH + taken))


@fused_disjoint
def _average(weights: Floats, averaged: Floats, share: float) -> None:
    part = weights.dtype.type(share)
    for k in range(len(weights)):
        averaged[k] += part * (weights[k] - averaged[k])


@fused_free
def drive(
    rules: Rules,
    state: LearnerState,
    scratch: Scratch,
    step: FunctionPointer,
    held: Struct,
    stack: Bytes,
    begins: bool,
    steps: int,
) -> None:
    """Act, look, learn.

    Args:
        rules: the constants of the run.
        state: the learner's.
        scratch: buffers.
        step: address of `kernel.advance`.
        held: address of a `Held`.
        stack: what the agent sees: (inputs,).
        begins: whether to choose a first action before, for what it sees now.
        steps: transitions.
    """
    if begins:
        begin(rules, state, scratch, stack)
    action = state.pending[:1]
    for _ in range(steps):
        contact, reward = False, 0.0
        for repeated in range(1, rules.action_repeat + 1):
            tasks = MOVE + LOOK if repeated == rules.action_repeat else MOVE
            step_world(step, held, action, scratch.met, tasks, 0, 1)
            contact |= scratch.met[0]
            reward += rules.reward_contact if scratch.met[0] else rules.reward_step
        learn_step(rules, state, scratch, stack, contact, reward)
