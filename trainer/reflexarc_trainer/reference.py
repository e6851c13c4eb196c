r"""SARSA(λ) to be read: torch, autograd, one visible update. The compiled loop must equal it.

The paper's equation (1), with a′ chosen ε-greedily and then executed, is

    Q(s, a) ← (1 − α) Q(s, a) + α (r + γ Q(s′, a′))  =  Q(s, a) + α δ,
    δ = r + γ Q(s′, a′) − Q(s, a).

With a network in place of the table, every weight that helped to choose the action moves, and the
trace e remembers how much each one did:

    e ← γ λ e + ∇Q(s, a),        w ← w + step · δ · e,

accumulating over all parameters, of the chosen action's output only. In the tabular case ∇Q is 1
at (s, a) and 0 elsewhere, and this is equation (1) again. The literal step is α. The bounded one,

    step = min(α, 1 / (κ · max(1, |δ|) · ‖e‖₁)),

never removes more than the TD error (arXiv 2410.14606): a network with linear outputs needs it,
for there α = 0.5 overshoots about tenfold.

Departures from the paper, which is silent on them: a contact pays −1 alone, the trace is cut at
it, and the value bootstraps from the place where the agent goes on.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from reflexarc_runtime.arrays import Actions
from reflexarc_trainer.choice import Stream, choose
from reflexarc_trainer.config import LearnerConfig
from reflexarc_trainer.schedules import linear_epsilon


class Body(Protocol):
    """One agent in a world; a `Simulation` of one agent is such a body."""

    def sense(self) -> npt.NDArray[np.uint8]:
        """What it sees where it stands: uint8 (1, eyes, rays, channels)."""
        ...

    def step(self, actions: Actions) -> npt.NDArray[np.bool_]:
        """Act (1,) and say whether that ended in a contact (1,)."""
        ...


@dataclass(frozen=True)
class Transition:
    """What one step brought."""

    action: int
    reward: float
    contact: bool
    td_error: float


class SarsaLambda:
    """The update rule, over the parameters of any module that maps retinas to Q-values."""

    def __init__(self, network: nn.Module, config: LearnerConfig) -> None:
        self.network = network
        self.config = config
        self.weights = list(network.parameters())
        self.trace = [torch.zeros_like(w) for w in self.weights]

    def update(
        self, s: Tensor, a: int, reward: float, s_next: Tensor, a_next: int, contact: bool
    ) -> float:
        """Learn from (s, a, r, s′, a′); returns the TD error δ."""
        config = self.config
        q, gradient = self._value_and_gradient(s, a)
        q_next = (
            0.0 if contact and config.after_contact == "terminal" else self._value(s_next, a_next)
        )
        td_error = reward + config.gamma * q_next - q
        for e, g in zip(self.trace, gradient, strict=True):
            e.mul_(config.gamma * config.trace_decay).add_(g)
        step = self._step_size(td_error)
        with torch.no_grad():
            for w, e in zip(self.weights, self.trace, strict=True):
                w.add_(step * td_error * e)
        if contact:
            self.cut_trace()
        return td_error

    def cut_trace(self) -> None:
        """What comes next owes nothing to what came before."""
        for e in self.trace:
            e.zero_()

    def _step_size(self, td_error: float) -> float:
        if self.config.step == "literal":
            return self.config.alpha
        norm = sum(float(e.abs().sum()) for e in self.trace)
        bound = self.config.kappa * max(1.0, abs(td_error)) * norm
        return min(self.config.alpha, 1.0 / bound) if bound > 0.0 else self.config.alpha

    def _value_and_gradient(self, s: Tensor, a: int) -> tuple[float, tuple[Tensor, ...]]:
        q = self.network(s)[0, a]
        return float(q.detach()), torch.autograd.grad(q, self.weights, materialize_grads=True)

    def _value(self, s: Tensor, a: int) -> float:
        with torch.no_grad():
            return float(self.network(s)[0, a])


class Explorer:
    """ε-greedy choice with a decaying ε; a chosen action is held, a contact ends the hold."""

    def __init__(self, config: LearnerConfig, stream: Stream, steps: int) -> None:
        self._config, self._stream = config, stream
        self._decay_steps = config.epsilon_span * steps
        self._step, self._left, self._action = 0, 0, 0

    def choose(self, q_values: Tensor, contact: bool = False) -> int:
        """The next action, for Q-values (actions,)."""
        if contact or self._left == 0:
            self._action = choose(q_values.double().numpy(), self._epsilon(), self._stream)
            self._left = self._config.held_actions
        self._left -= 1
        self._step += 1
        return self._action

    def _epsilon(self) -> float:
        config = self._config
        return linear_epsilon(
            self._step, config.epsilon_start, config.epsilon_end, self._decay_steps
        )


def learn(
    network: nn.Module, body: Body, config: LearnerConfig, stream: Stream, steps: int
) -> Iterator[Transition]:
    """Sense, act, learn; one transition after another for `steps` steps.

    Args:
        network: maps retinas (1, frames, eyes, rays, channels) to Q-values (1, actions); its
            parameters are changed in place.
        body: where it lives.
        config: the learner.
        stream: where the exploration draws from; changed in place.
        steps: length of the run; ε follows from it.
    """
    learner = SarsaLambda(network, config)
    explorer = Explorer(config, stream, steps)
    s = _sense(body)
    a = explorer.choose(_q_values(network, s))
    for _ in range(steps):
        contact = bool(body.step(np.array([a], np.int64))[0])
        reward = config.reward_contact if contact else config.reward_step
        s_next = _sense(body)
        a_next = explorer.choose(_q_values(network, s_next), contact)
        td_error = learner.update(s, a, reward, s_next, a_next, contact)
        yield Transition(a, reward, contact, td_error)
        s, a = s_next, a_next


def _sense(body: Body) -> Tensor:
    """One frame (1, 1, eyes, rays, channels): a copy, for a body may reuse its buffer."""
    return torch.tensor(body.sense()[:, np.newaxis])


def _q_values(network: nn.Module, s: Tensor) -> Tensor:
    with torch.no_grad():
        q_values: Tensor = network(s)[0]
    return q_values
