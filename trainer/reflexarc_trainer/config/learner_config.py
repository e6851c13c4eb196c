"""Configuration of the network, of the exploration, and of SARSA(λ) in its two forms.

The defaults are the paper's ("Reactive Vision-Based Navigation Controller for Autonomous Mobile
Agents": α = 0.5, λ = 0.9, γ = 0.9, 16–10–3, reward +0.1 per step and −1 for a collision). Where the
paper says nothing, a field documents the choice and its alternatives.
"""

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from reflexarc_runtime.config.checks import (
    require,
    require_count,
    require_finite,
    require_one_of,
    require_share,
)
from reflexarc_runtime.contract.contract import PolicyContract

Form = Literal["online", "batched"]
StepRule = Literal["bounded", "intentional", "rmsprop", "literal"]
Units = Literal["sigmoid", "tanh", "relu"]
OutputUnits = Literal["linear", "sigmoid"]
TdTarget = Literal["sampled", "expected", "greedy"]
Optimiser = Literal["adam", "radam"]
Precision = Literal["float32", "float64"]
InitialWeights = Literal["scaled", "normal"]
AfterContact = Literal["bootstrap", "terminal"]

MOST_LAYERS = 3
MOST_UNITS = 4096


@dataclass(frozen=True)
class NetworkConfig:
    """Retina → hidden layers → one Q-value per action (the paper: 16–10–3, sigmoid units)."""

    hidden: tuple[int, ...] = (10,)
    """Number of units of each hidden layer; one to three layers. A plain number means one layer."""
    units: Units = "sigmoid"
    """Activation function of the hidden units."""
    output: OutputUnits = "sigmoid"
    """Activation function of the output units. Sigmoid ones, which the paper has, cannot represent
    the negative value of a certain collision."""
    input_power: int = 1
    """Each input in [0, 1] is raised to this whole power, which stresses near obstacles."""
    initial_weights: InitialWeights = "scaled"
    """`scaled`: standard deviation 1/√(inputs of the unit), biases 0; `normal`: N(0, 1)."""

    def __post_init__(self) -> None:
        given: Any = self.hidden  # files may contain a number or a list
        layers = (given,) if isinstance(given, int) else tuple(given)
        object.__setattr__(self, "hidden", layers)
        require(1 <= len(layers) <= MOST_LAYERS, "network.hidden", "1 to 3 layers", layers)
        for units in layers:
            require_count("network.hidden", units, MOST_UNITS)
        require_count("network.input_power", self.input_power, 64)
        require_one_of(Units, "network.units", self.units)
        require_one_of(OutputUnits, "network.output", self.output)
        require_one_of(InitialWeights, "network.initial_weights", self.initial_weights)

    def sizes(self, contract: PolicyContract) -> list[int]:
        """Numbers of inputs, of hidden units in each layer, and of actions: (layers + 1,)."""
        inputs = contract.retina.frames * contract.retina.size
        return [inputs, *self.hidden, len(contract.actions)]


@dataclass(frozen=True)
class ExplorationConfig:
    """ε-greedy choice of actions; ε falls linearly."""

    epsilon_start: float = 1.0
    """ε, the probability of a random action, at the first step."""
    epsilon_end: float = 0.02
    """ε after the decay."""
    epsilon_span: float = 0.5
    """Share of the run over which ε decays."""
    held_actions: int = 1
    """Transitions for which a chosen action is held while learning; a contact ends the hold."""
    action_repeat: int = 1
    """World steps per action while learning. They are one transition: their rewards are added, γ
    counts them as one, and nothing is sensed in between. The learned policy, where it is used,
    decides at every step."""
    margin: float = 0.0
    """While learning, the greedy part of the choice keeps the action of the transition before
    unless another one leads it by this share of the spread of the Q-values; a contact ends that.
    Then Q is the value of a policy that drives with such a margin."""
    least_lead: float = 0.0
    """Nor is another one taken unless it leads by this, in the unit of the Q-values."""

    def __post_init__(self) -> None:
        for name in ("epsilon_start", "epsilon_end", "epsilon_span"):
            require_share(f"exploration.{name}", getattr(self, name))
        require_share("exploration.margin", self.margin)
        lead = self.least_lead
        require(0.0 <= lead < math.inf, "exploration.least_lead", "0 or more, and finite", lead)
        require_count("exploration.held_actions", self.held_actions, 1000)
        require_count("exploration.action_repeat", self.action_repeat, 1000)
        require(
            self.action_repeat == 1 or self.held_actions == 1,
            "exploration.held_actions",
            "1 where exploration.action_repeat is more",
            self.held_actions,
        )


@dataclass(frozen=True)
class OnlineConfig:
    """One agent, eligibility traces, one update per transition: what the paper describes."""

    alpha: float = 0.5
    """Step size α. Bounded: its upper limit. Intentional: the share of the TD error that an update
    removes. RMSProp: the change of a weight whose δe equals its running RMS."""
    alpha_end: float = 1.0
    """Share of α that is left at the end of the run; α falls linearly."""
    step: StepRule = "bounded"
    """`bounded`: α is reduced where one update would overshoot; `intentional`: an update removes
    the share α of the TD error; `rmsprop`: each weight's δe is divided by its running RMS;
    `literal`: α is taken as it is (this diverges with linear outputs)."""
    kappa: float = 2.0
    """κ of the bounded step: one update removes at most 1/κ of the TD error."""
    precision: Precision = "float32"
    """Floating-point type of weights, traces and values while learning."""

    def __post_init__(self) -> None:
        require(0.0 < self.alpha <= 1e3, "learner.online.alpha", "in (0, 1000]", self.alpha)
        require_share("learner.online.alpha_end", self.alpha_end)
        require(1.0 <= self.kappa < math.inf, "learner.online.kappa", "1 or more", self.kappa)
        require_one_of(StepRule, "learner.online.step", self.step)
        require_one_of(Precision, "learner.online.precision", self.precision)


@dataclass(frozen=True)
class BatchedConfig:
    """Many agents, λ-returns over short roll-outs, one or more gradient steps after each."""

    agents: int = 512
    """Number of agents, each in a training world of its own."""
    shard_agents: int = 64
    """Number of agents that one thread computes together. The bits of a run depend on it, but not
    on the number of threads."""
    rollout_steps: int = 16
    """Transitions of each agent between two updates."""
    epochs: int = 1
    """Number of times that each roll-out is learned from."""
    minibatches: int = 1
    """Gradient steps per epoch; each takes every n-th transition of every agent."""
    optimiser: Optimiser = "adam"
    """Optimiser of the gradient steps."""
    learning_rate: float = 3e-3
    """Learning rate of the optimiser at the start of the run."""
    learning_rate_end: float = 0.0
    """Share of the learning rate that is left at the end of the run; it falls linearly."""
    max_gradient_norm: float = 10.0
    """A gradient with a larger norm is shortened to this norm."""
    precision: Precision = "float32"
    """Floating-point type of weights and values while learning."""

    def __post_init__(self) -> None:
        limits = {"agents": 1 << 20, "shard_agents": 1 << 12, "rollout_steps": 1 << 12}
        limits |= {"epochs": 100, "minibatches": 1000}
        for name, most in limits.items():
            require_count(f"learner.batched.{name}", getattr(self, name), most)
        require(
            self.agents % self.shard_agents == 0,
            "learner.batched.agents",
            f"a multiple of shard_agents = {self.shard_agents}",
            self.agents,
        )
        require(
            self.minibatches <= self.rollout_steps,
            "learner.batched.minibatches",
            f"at most rollout_steps = {self.rollout_steps}",
            self.minibatches,
        )
        rate, norm = self.learning_rate, self.max_gradient_norm
        require(0.0 < rate <= 10.0, "learner.batched.learning_rate", "in (0, 10]", rate)
        require_share("learner.batched.learning_rate_end", self.learning_rate_end)
        require(0.0 < norm < math.inf, "learner.batched.max_gradient_norm", "positive", norm)
        require_one_of(Optimiser, "learner.batched.optimiser", self.optimiser)
        require_one_of(Precision, "learner.batched.precision", self.precision)

    @property
    def batch_steps(self) -> int:
        """Transitions of a roll-out, all agents together."""
        return self.agents * self.rollout_steps


@dataclass(frozen=True)
class LearnerConfig:
    """SARSA(λ): its form, its targets and its rewards."""

    form: Form = "online"
    """`online`: one agent, traces, an update per transition; `batched`: λ-returns, many agents."""
    trace_decay: float = 0.9
    """λ: how far back a TD error changes earlier values; with 0 only the last one."""
    gamma: float = 0.9
    """Discount γ per transition."""
    target: TdTarget = "sampled"
    """Value of the next state in a target: that of the action chosen there (`sampled`, SARSA), the
    expectation over the ε-greedy choice (`expected`), or that of the best action (`greedy`, Q(λ)
    after Peng & Williams, "Incremental multi-step Q-learning", 1996; batched only)."""
    reward_step: float = 0.1
    """Reward of a step without a contact."""
    reward_contact: float = -1.0
    """Reward of a step with a contact, in place of `reward_step`."""
    reward_switch: float = 0.0
    """Reward of a transition with another action than the one before, besides what it earns; after
    a contact there is none before. A negative one makes switches cost something. It is not centred.
    """
    reward_centring: float = 0.0
    """Reward centring (arXiv 2405.09999): a running average is subtracted from every reward; this
    is the share by which it moves towards the last one at each update. 0 turns it off."""
    after_contact: AfterContact = "bootstrap"
    """Whether the value of the state after a contact counts (`bootstrap`) or not (`terminal`). The
    trace is cut in both cases."""
    averaged_weights: float = 0.0
    """Share of itself that a running average of the weights keeps at each update. The average is
    validated and exported. 0 takes the last weights."""
    exploration: ExplorationConfig = field(default_factory=ExplorationConfig)
    """Choice of actions while learning."""
    online: OnlineConfig = field(default_factory=OnlineConfig)
    """Settings of the online form."""
    batched: BatchedConfig = field(default_factory=BatchedConfig)
    """Settings of the batched form."""

    def __post_init__(self) -> None:
        require_share("learner.trace_decay", self.trace_decay)
        gamma = self.gamma
        require(0.0 <= gamma < 1.0, "learner.gamma", "in [0, 1): the task never ends", gamma)
        for name in ("reward_step", "reward_contact", "reward_switch"):
            require_finite(f"learner.{name}", getattr(self, name))
        require_share("learner.reward_centring", self.reward_centring)
        keep = self.averaged_weights
        require(0.0 <= keep < 1.0, "learner.averaged_weights", "in [0, 1)", keep)
        require_one_of(Form, "learner.form", self.form)
        require_one_of(TdTarget, "learner.target", self.target)
        fits = self.form == "batched" or self.target != "greedy"
        require(fits, "learner.target", "sampled or expected with form = 'online'", self.target)
        require_one_of(AfterContact, "learner.after_contact", self.after_contact)
