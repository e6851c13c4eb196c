r"""Online SARSA(λ) for one agent, compiled: the algorithm of `reference.py`, with the same results.

One update per transition (s, a, r, s′, a′), for a network with one hidden layer:

    δ = r − r̄ + γ V(s′) − Q(s, a)        V(s′) is Q(s′, a′), or its expectation over a′
    e ← γλ e + ∇Q(s, a)                  the trace; a contact cuts it
    w ← w + step · δ · e                 the step rules are in `traces.py`

The weights are one flat vector, laid out as `weight_rows.py` says, so that trace, norm and update
are single long loops. All that the next update depends on is in `LearnerState`.
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
from reflexarc_trainer.sarsa.exploration import FREE, choose, expected_value, greedy
from reflexarc_trainer.sarsa.online.network_pass import fill_gradient, forward
from reflexarc_trainer.sarsa.online.state import (
    NEXT,
    NOW,
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
    clip_td_error,
    move,
    move_by_rms,
    move_intentionally,
    rescale,
)
from reflexarc_trainer.sarsa.step_rules import SCALED_AT_FIRST, SCALED_EVERY, SQUARES_KEPT

AVERAGED_EVERY = 16
"""The average over weights takes in every 16th update's weights, with the share of all 16."""

linear = compiled(schedules.linear)

_LEAST_TENTH = 10.0
"""Early in a run the average reaches back over a tenth of it: the first weights are random."""


@fused_inline
def begin(rules: Rules, state: LearnerState, scratch: Scratch, retina: Bytes) -> None:
    """Choose the first action in a world, for what is seen there.

    Args:
        rules: the constants of the run.
        state: of the learner; its action and inputs are set.
        scratch: buffers.
        retina: (inputs,).
    """
    _encode(state, scratch, retina)
    forward(rules, scratch)
    step = state.progress[0].step
    state.action[0] = _next_action(rules, state, scratch.choices, step, FREE)
    _copy(scratch.inputs[NEXT], state.inputs)


@fused_inline
def learn_step(
    rules: Rules,
    state: LearnerState,
    scratch: Scratch,
    retina: Bytes,
    contact: bool,
    reward: float,
) -> float:
    """Learn from one transition, and choose the next action.

    Args:
        rules: the constants of the run.
        state: of the learner; it is moved on by one transition.
        scratch: buffers.
        retina: what is seen in s′: (inputs,).
        contact: whether the pending action ended in a contact.
        reward: what it earned.

    Returns:
        The TD error δ.
    """
    progress = state.progress[0]
    action, step = state.action[0], progress.step + 1
    _encode(state, scratch, retina)
    forward(rules, scratch)
    in_force = FREE if contact else action
    next_action = _next_action(rules, state, scratch.choices, step, in_force)
    target = _target(rules, state, scratch.choices, next_action, step, in_force, reward)
    td_error: float = target - scratch.q_values[NOW, action]
    fill_gradient(rules, scratch, action)
    move_weights(rules, state, scratch.gradient, td_error, step)
    if contact:
        state.trace[:] = 0.0
    _copy(scratch.inputs[NEXT], state.inputs)
    state.action[0], progress.step = next_action, step
    progress.sum_abs_error += abs(td_error)
    return td_error


@fused_inline
def move_weights(
    rules: Rules, state: LearnerState, gradient: Floats, td_error: float, step: int
) -> None:
    """Update trace and weights by the run's step rule; `step` counts transitions from 1."""
    alpha = linear(step - 1, rules.alpha, rules.alpha_end, rules.steps)
    norm = accumulate(state.trace, gradient, rules.gamma * rules.trace_decay)
    if rules.step == INTENTIONAL:
        progress, square = state.progress[0], td_error * td_error
        progress.mean_square += (1.0 - SQUARES_KEPT) * (square - progress.mean_square)
        clipped = clip_td_error(td_error, progress.mean_square, step)
        move_intentionally(state.weights, state.trace, state.squares, gradient, alpha * clipped)
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
def averaged_share(kept: float, step: int) -> float:
    """Share of the new weights in their average, which keeps `kept` of itself at each update."""
    taken = step / AVERAGED_EVERY
    return max(1.0 - kept**AVERAGED_EVERY, _LEAST_TENTH / (_LEAST_TENTH + taken))


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
    """Act, sense and learn, for a number of transitions.

    Args:
        rules: the constants of the run.
        state: of the learner.
        scratch: buffers.
        step: address of the compiled function `simulation.step.advance`.
        held: address of what it works on: see `simulation.step_pointer.Held`.
        stack: memory where the world puts what the agent sees: (inputs,).
        begins: whether to choose a first action for what is seen now.
        steps: number of transitions.
    """
    if begins:
        begin(rules, state, scratch, stack)
    for _ in range(steps):
        contact, reward = False, 0.0
        for repeated in range(1, rules.action_repeat + 1):
            tasks = MOVE + LOOK if repeated == rules.action_repeat else MOVE
            step_world(step, held, state.action, scratch.met, tasks, 0, 1)
            contact |= scratch.met[0]
            reward += rules.reward_contact if scratch.met[0] else rules.reward_step
        learn_step(rules, state, scratch, stack, contact, reward)


@fused_inline
def _target(
    rules: Rules,
    state: LearnerState,
    q_values: Floats,
    action: int,
    step: int,
    in_force: int,
    reward: float,
) -> float:
    """The target r − r̄ + γ V(s′); moves the average reward r̄. After a contact none is in force."""
    progress = state.progress[0]
    target: float = reward - rules.action_repeat * progress.average_reward
    deviation = reward / rules.action_repeat - progress.average_reward
    progress.average_reward += rules.centring * deviation
    if in_force == FREE and rules.terminal:
        return target
    if rules.expected:
        best = greedy(q_values, 0, in_force, rules.margin, rules.least_lead)
        target += rules.gamma * expected_value(q_values, 0, _epsilon(rules, step), best)
    else:
        target += rules.gamma * q_values[action, 0]
    if rules.reward_switch != 0.0 and in_force not in (FREE, action):
        target += rules.gamma * rules.reward_switch
    return target


@fused_inline
def _next_action(rules: Rules, state: LearnerState, q: Floats, step: int, in_force: int) -> int:
    """The action in force while it is held, else an ε-greedy choice; a contact ends the hold."""
    progress = state.progress[0]
    if progress.held_actions > 0 and in_force != FREE:
        progress.held_actions -= 1
        return in_force
    progress.held_actions = rules.held_actions - 1
    epsilon, margin, least_lead = _epsilon(rules, step), rules.margin, rules.least_lead
    return choose(q, 0, epsilon, state.streams, 0, in_force, margin, least_lead)


@fused_inline
def _epsilon(rules: Rules, step: int) -> float:
    return linear(step, rules.epsilon_start, rules.epsilon_end, rules.epsilon_steps)


@fused_inline
def _encode(state: LearnerState, scratch: Scratch, retina: Bytes) -> None:
    """Fill the inputs of s from the state and those of s′ from a retina, by the input curve."""
    _copy(state.inputs, scratch.inputs[NOW])
    x_next = scratch.inputs[NEXT]
    for i in range(len(retina)):
        x_next[i] = scratch.curve[retina[i]]


@fused_inline
def _copy(source: Floats, target: Floats) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@fused_disjoint
def _average(weights: Floats, averaged: Floats, share: float) -> None:
    part = weights.dtype.type(share)
    for k in range(len(weights)):
        averaged[k] += part * (weights[k] - averaged[k])
