r"""SARSA(λ) in torch, made to be read: autograd and one visible update.

The compiled online form makes the same updates (the tests compare).

The paper is "Reactive Vision-Based Navigation Controller for Autonomous Mobile Agents". Its
equation (1), with a′ chosen ε-greedily and then executed, is

    Q(s, a) ← (1 − α) Q(s, a) + α (r + γ Q(s′, a′))  =  Q(s, a) + α δ,
    δ = r + γ Q(s′, a′) − Q(s, a).

With a network in place of the table, the update moves the weights w along an accumulating
eligibility trace e of the gradients of the chosen actions' values:

    e ← γ λ e + ∇Q(s, a),        w ← w + step · δ · e.

In the tabular case ∇Q is 1 at (s, a) and 0 elsewhere, and with λ = 0 this is equation (1) again.
There are four step rules. The literal step is α. The bounded step,

    step = min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁)),

never removes more than the TD error (arXiv 2410.14606). Networks with linear outputs need it:
with α = 0.5 the literal step overshoots about tenfold. The intentional step (arXiv 2604.19033)
removes the share α of the TD error if the trace is the gradient; s is the reciprocal of the running
RMS of each weight's gradient:

    w ← w + α δ s e / Σ s e².

The step by RMS (RMSProp, Tieleman & Hinton, 2012) divides each weight's δe by its running RMS,
which is recomputed at some of the updates only (`online/traces.py`).

Expected SARSA replaces Q(s′, a′) by its expectation over the ε-greedy choice of a′. Reward centring
(arXiv 2405.09999) subtracts a running average from r. With a margin or a least lead the choice
keeps the action a, which is in force in s′, unless another one leads it by enough; a may be kept,
so Q(s, a) is the value of doing a and holding it thus. A switch pays `reward_switch` as s′ is left,
hence γ times that in the target of (s, a).

Where the paper says nothing: a contact pays −1 alone, it cuts the trace, and its target bootstraps
from the state in which the agent continues.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from reflexarc_runtime.arrays import Actions
from reflexarc_trainer.config.learner_config import LearnerConfig
from reflexarc_trainer.sarsa.exploration import FREE, Streams, choose, greedy
from reflexarc_trainer.sarsa.schedules import linear
from reflexarc_trainer.sarsa.step_rules import (
    LARGEST_RATIO,
    LARGEST_TD_ERROR,
    LEAST_RMS,
    LEAST_TOTAL,
    SCALED_AT_FIRST,
    SCALED_EVERY,
    SQUARES_KEPT,
)


class AgentBody(Protocol):
    """One agent in a world, for example a `Simulation` of one agent."""

    def sense(self) -> npt.NDArray[np.uint8]:
        """What the agent sees: uint8 (1, eyes, rays, channels)."""
        ...

    def step(self, actions: Actions) -> npt.NDArray[np.bool_]:
        """Do an action (1,); returns whether it ended in a contact (1,)."""
        ...


@dataclass(frozen=True)
class Transition:
    """A transition that was learned from."""

    action: int
    reward: float
    contact: bool
    td_error: float


class SarsaLambda:
    """The update rule, over the parameters of any module that maps retinas to Q-values.

    Args:
        network: its parameters are changed in place.
        config: the learner.
        steps: transitions of the whole run, over which α falls.
    """

    def __init__(self, network: nn.Module, config: LearnerConfig, steps: int = 1) -> None:
        self.network, self.config, self.steps = network, config, steps
        self.weights = list(network.parameters())
        self.trace = [torch.zeros_like(w) for w in self.weights]
        self.squares = [torch.zeros_like(w) for w in self.weights]
        self.scales = [torch.zeros_like(w) for w in self.weights]
        self.step, self.average_reward, self.mean_square = 0, 0.0, 0.0

    def update(
        self,
        s: Tensor,
        a: int,
        reward: float,
        s_next: Tensor,
        a_next: int,
        contact: bool,
        epsilon: float = 0.0,
    ) -> float:
        """Learn from (s, a, r, s′, a′), a′ chosen with `epsilon`; returns the TD error δ."""
        config = self.config
        q, gradient = self._value_and_gradient(s, a)
        repeat = config.exploration.action_repeat
        centred = reward - repeat * self.average_reward
        self.average_reward += config.reward_centring * centred / repeat
        terminal = contact and config.after_contact == "terminal"
        in_force = FREE if contact else a
        q_next = 0.0 if terminal else self._next_value(s_next, a_next, in_force, epsilon)
        td_error = centred + config.gamma * q_next - q
        for e, g in zip(self.trace, gradient, strict=True):
            e.mul_(config.gamma * config.trace_decay).add_(g)
        change = self._change(td_error, gradient)
        with torch.no_grad():
            for w, dw in zip(self.weights, change, strict=True):
                w.add_(dw)
        if contact:
            self.cut_trace()
        self.step += 1
        return td_error

    def cut_trace(self) -> None:
        """Set the trace to 0, so that later TD errors do not change earlier values."""
        for e in self.trace:
            e.zero_()

    def _change(self, td_error: float, gradient: tuple[Tensor, ...]) -> list[Tensor]:
        """The change of the weights, step · δ · e, by the step rule."""
        online = self.config.online
        alpha = linear(self.step, online.alpha, online.alpha * online.alpha_end, self.steps)
        if online.step == "intentional":
            return self._intentional_change(alpha, td_error, gradient)
        if online.step == "rmsprop":
            return self._rmsprop_change(alpha, td_error)
        step = alpha
        norm = sum(float(e.abs().sum()) for e in self.trace)
        bound = online.kappa * max(1.0, abs(td_error)) * norm
        if online.step == "bounded" and bound > 0.0:
            step = min(alpha, 1.0 / bound)
        return [step * td_error * e for e in self.trace]

    def _intentional_change(
        self, alpha: float, td_error: float, gradient: tuple[Tensor, ...]
    ) -> list[Tensor]:
        self.mean_square += (1.0 - SQUARES_KEPT) * (td_error**2 - self.mean_square)
        unbiased = self.mean_square / (1.0 - SQUARES_KEPT ** (self.step + 1))
        limit = LARGEST_TD_ERROR * math.sqrt(unbiased)
        for v, g in zip(self.squares, gradient, strict=True):
            v.mul_(SQUARES_KEPT).add_((1.0 - SQUARES_KEPT) * g**2)
        scaled = [e / (v.sqrt() + 1e-12) for e, v in zip(self.trace, self.squares, strict=True)]
        total = sum(float((e * se).sum()) for e, se in zip(self.trace, scaled, strict=True))
        share = alpha * min(max(td_error, -limit), limit) / total if total > LEAST_TOTAL else 0.0
        return [share * se for se in scaled]

    def _rmsprop_change(self, alpha: float, td_error: float) -> list[Tensor]:
        steps, change = self.step + 1, []
        for e, v, s in zip(self.trace, self.squares, self.scales, strict=True):
            g = td_error * e
            change.append(alpha * (s * g).clamp(-LARGEST_RATIO, LARGEST_RATIO))
            v.mul_(SQUARES_KEPT).add_((1.0 - SQUARES_KEPT) * g**2)
            if steps <= SCALED_AT_FIRST or steps % SCALED_EVERY == 0:
                s.copy_(1.0 / ((v / (1.0 - SQUARES_KEPT**steps)).sqrt() + LEAST_RMS))
        return change

    def _value_and_gradient(self, s: Tensor, a: int) -> tuple[float, tuple[Tensor, ...]]:
        q = self.network(s)[0, a]
        return float(q.detach()), torch.autograd.grad(q, self.weights, materialize_grads=True)

    def _next_value(self, s: Tensor, a: int, in_force: int, epsilon: float) -> float:
        paid = self.config.reward_switch if in_force not in (FREE, a) else 0.0
        q_values = _q_values(self.network, s)
        if self.config.target == "sampled":
            return float(q_values[a]) + paid
        explore, column = self.config.exploration, q_values.double().numpy()[:, np.newaxis]
        best = greedy(column, 0, in_force, explore.margin, explore.least_lead)
        return float((1.0 - epsilon) * q_values[best] + epsilon * q_values.mean()) + paid


class Explorer:
    """ε-greedy choice with decaying ε; an action is held for some steps, and then until another
    one leads it by enough, or until a contact.
    """

    def __init__(self, config: LearnerConfig, streams: Streams, steps: int) -> None:
        self._config, self._streams = config.exploration, streams
        self._decay_steps = self._config.epsilon_span * steps
        self._step, self._left, self._action = 0, 0, FREE

    def choose(self, q_values: Tensor, contact: bool = False) -> int:
        """The next action, given the Q-values (actions,) of the state."""
        if contact or self._left == 0:
            column = q_values.double().numpy()[:, np.newaxis]
            in_force, explore = FREE if contact else self._action, self._config
            least = explore.margin, explore.least_lead
            self._action = choose(column, 0, self.epsilon, self._streams, 0, in_force, *least)
            self._left = self._config.held_actions
        self._left -= 1
        self._step += 1
        return self._action

    @property
    def epsilon(self) -> float:
        """The exploration rate ε of the next choice."""
        config = self._config
        return linear(self._step, config.epsilon_start, config.epsilon_end, self._decay_steps)


def learn(
    network: nn.Module, body: AgentBody, config: LearnerConfig, streams: Streams, steps: int
) -> Iterator[Transition]:
    """Act, sense and learn for a number of transitions; yields each.

    Args:
        network: maps retinas (1, frames, eyes, rays, channels) to Q-values (1, actions); its
            parameters are changed in place.
        body: the agent in its world.
        config: the learner.
        streams: random stream of the exploration, changed in place: (1,).
        steps: number of transitions, over which ε and α fall.
    """
    learner = SarsaLambda(network, config, steps)
    explorer = Explorer(config, streams, steps)
    rewards, repeat = (config.reward_step, config.reward_contact), config.exploration.action_repeat
    s = _sense(body)
    a = explorer.choose(_q_values(network, s))
    for _ in range(steps):
        contacts = [body.step(np.array([a], np.int64))[0] for _ in range(repeat)]
        contact, reward = any(contacts), sum(rewards[bool(each)] for each in contacts)
        s_next = _sense(body)
        epsilon = explorer.epsilon
        a_next = explorer.choose(_q_values(network, s_next), contact)
        td_error = learner.update(s, a, reward, s_next, a_next, contact, epsilon)
        yield Transition(a, reward, contact, td_error)
        s, a = s_next, a_next


def _sense(body: AgentBody) -> Tensor:
    """What the agent sees (1, 1, eyes, rays, channels): a copy, as a body may reuse its buffer."""
    return torch.tensor(body.sense()[:, np.newaxis])


def _q_values(network: nn.Module, s: Tensor) -> Tensor:
    with torch.no_grad():
        q_values: Tensor = network(s)[0]
    return q_values
