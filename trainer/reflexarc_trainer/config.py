"""What a training run is made of: nested frozen dataclasses, checked on construction.

The learner's defaults are the paper's ("Reactive Vision-Based Navigation Controller for Autonomous
Mobile Agents": α = 0.5, λ = 0.9, γ = 0.9, 16–10–3, +0.1 a step, −1 a collision); where the paper
is silent, a field names the choice and its alternatives. Schedules count steps, never seconds.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Self, get_args

from reflexarc_runtime.contract import (
    PolicyContract,
    Provenance,
    RetinaSpec,
    Shading,
    sideways_actions,
)
from reflexarc_runtime.errors import ContractError, UsageError

StepRule = Literal["bounded", "literal"]
OutputUnits = Literal["linear", "sigmoid"]
InitialWeights = Literal["scaled", "normal"]
AfterContact = Literal["bootstrap", "terminal"]


@dataclass(frozen=True)
class LearnerConfig:
    """SARSA(λ) with one hidden layer of sigmoid units."""

    alpha: float = 0.5
    """Step size α; with the bounded step its upper limit."""
    trace_decay: float = 0.9
    """λ: how far back a TD error reaches. 0 keeps no trace."""
    gamma: float = 0.9
    """Discount γ a step."""
    step: StepRule = "bounded"
    """`bounded`: α is cut where one update would overshoot; `literal`: α as it is (diverges with
    linear outputs)."""
    kappa: float = 2.0
    """κ of the bounded step: 1/κ of the TD error is the most that one update may remove."""
    hidden: int = 10
    """Hidden units."""
    output: OutputUnits = "sigmoid"
    """Output units. Sigmoid ones, the paper's words taken literally, cannot hold the negative value
    of a certain collision, and yet learn as well as linear ones and more evenly over seeds."""
    initial_weights: InitialWeights = "scaled"
    """`scaled`: standard deviation 1/√(inputs of the unit), biases 0; `normal`: N(0, 1)."""
    reward_step: float = 0.1
    """Reward of a step without a contact."""
    reward_contact: float = -1.0
    """Reward of a step with a contact, which gets no `reward_step`."""
    after_contact: AfterContact = "bootstrap"
    """After a contact the value of the new place counts (`bootstrap`) or not (`terminal`). The
    trace is cut in both cases."""
    epsilon_start: float = 1.0
    """Share of random actions at the first step."""
    epsilon_end: float = 0.02
    """Share of random actions once the decay is over."""
    epsilon_span: float = 0.5
    """Share of the run over which ε decays linearly."""
    held_actions: int = 1
    """Steps for which a chosen action is held while learning; a contact ends the hold."""

    def __post_init__(self) -> None:
        _require(0.0 < self.alpha <= 1e3, "learner.alpha", "in (0, 1000]", self.alpha)
        for name in ("trace_decay", "epsilon_start", "epsilon_end", "epsilon_span"):
            value = getattr(self, name)
            _require(0.0 <= value <= 1.0, f"learner.{name}", "in [0, 1]", value)
        _require(
            0.0 <= self.gamma < 1.0, "learner.gamma", "in [0, 1): the task never ends", self.gamma
        )
        _require(1.0 <= self.kappa < math.inf, "learner.kappa", "1 or more", self.kappa)
        _require(1 <= self.hidden <= 4096, "learner.hidden", "1 to 4096", self.hidden)
        _require(
            1 <= self.held_actions <= 1000, "learner.held_actions", "1 to 1000", self.held_actions
        )
        for name in ("reward_step", "reward_contact"):
            _require(
                math.isfinite(getattr(self, name)), f"learner.{name}", "finite", getattr(self, name)
            )
        _require_one_of(StepRule, "learner.step", self.step)
        _require_one_of(OutputUnits, "learner.output", self.output)
        _require_one_of(InitialWeights, "learner.initial_weights", self.initial_weights)
        _require_one_of(AfterContact, "learner.after_contact", self.after_contact)


@dataclass(frozen=True)
class ValidationConfig:
    """How often, and on how much, the greedy policy is measured while it learns."""

    points: int = 20
    """Measurements over the run, at equal distances in steps; the last is at the end."""
    agents: int = 256
    """Agents, each in its own validation world."""
    steps: int = 300
    """Steps counted for each agent."""
    discard: int = 50
    """Steps before the counting begins."""

    def __post_init__(self) -> None:
        _require(1 <= self.points <= 10_000, "validation.points", "1 to 10000", self.points)
        _require(self.agents >= 1, "validation.agents", "1 or more", self.agents)
        _require(self.steps >= 1, "validation.steps", "1 or more", self.steps)
        _require(self.discard >= 0, "validation.discard", "0 or more", self.discard)


@dataclass(frozen=True)
class TrainConfig:
    """A whole training run."""

    preset: str = "reflex"
    """Name of the preset that this configuration started from."""
    seed: int = 0
    """Seed of the initial weights, the exploration and the training world."""
    steps: int = 500_000
    """Transitions to learn from."""
    world: str = "reference-1"
    """Name of the world to learn in."""
    forward_mps: float = 1.0
    """Forward speed of every action."""
    lateral_mps: float = 1.0
    """Sideways speed of left and right."""
    rate_hz: float = 50.0
    """Rate at which the exported policy is meant to run."""
    max_input_age_s: float = 0.1
    """Age at which an input of the exported policy is stale."""
    retina: RetinaSpec = field(default_factory=RetinaSpec)
    """The eye."""
    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """The learner."""
    validation: ValidationConfig = field(default_factory=ValidationConfig)
    """The measurements on the way."""

    def __post_init__(self) -> None:
        _require(0 <= self.seed < 1 << 63, "seed", "0 to 2^63 - 1", self.seed)
        _require(self.steps >= 1, "steps", "1 or more", self.steps)
        for name in ("forward_mps", "lateral_mps"):
            speed_mps = getattr(self, name)
            _require(0.0 < speed_mps < math.inf, name, "positive", speed_mps)

    def resolved(self) -> dict[str, Any]:
        """The configuration as plain JSON values, every default filled in."""
        document: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(self)))
        return document

    @property
    def hash(self) -> str:
        """SHA-256, in hexadecimal, of the canonical JSON of the resolved configuration."""
        text = json.dumps(self.resolved(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()

    @classmethod
    def from_resolved(cls, document: Mapping[str, Any]) -> Self:
        """Read back what `resolved` wrote.

        Raises:
            UsageError: a field is missing, unknown or out of range.
        """
        try:
            eye = {**document["retina"], "shading": Shading(document["retina"]["shading"])}
            parts = {
                "retina": RetinaSpec(**eye),
                "learner": LearnerConfig(**document["learner"]),
                "validation": ValidationConfig(**document["validation"]),
            }
            return cls(**{**document, **parts})
        except (KeyError, TypeError, ValueError, ContractError) as error:
            raise UsageError(
                f"configuration: not one of this version ({error}); train anew"
            ) from None

    def contract(self, provenance: Provenance | None = None) -> PolicyContract:
        """What the policy of this run sees and does."""
        return PolicyContract(
            retina=self.retina,
            actions=sideways_actions(self.forward_mps, self.lateral_mps),
            rate_hz=self.rate_hz,
            max_input_age_s=self.max_input_age_s,
            provenance=provenance or Provenance(),
        )


def _require(holds: bool, where: str, expected: str, got: object) -> None:
    if not holds:
        raise UsageError(f"{where}: expected {expected}, got {got}")


def _require_one_of(choices: Any, where: str, got: str) -> None:
    known = get_args(choices)
    _require(got in known, where, " or ".join(known), repr(got))
