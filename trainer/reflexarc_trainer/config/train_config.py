"""Configuration of a training run: nested frozen dataclasses, checked on construction.

Network and learner have their dataclasses in `learner_config.py`, worlds in `training_world.py`.
Lengths are numbers of transitions and never seconds, so that a run can be repeated.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Self

from reflexarc_runtime.config.checks import require, require_one_of, require_share
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_sim_bridge.worlds.world import World, WorldSource
from reflexarc_trainer.config.embodied import embodied
from reflexarc_trainer.config.learner_config import (
    BatchedConfig,
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
)
from reflexarc_trainer.config.older_configs import as_of_today, require_parts
from reflexarc_trainer.config.training_world import TrainingWorld

__all__ = [
    "BatchedConfig",
    "ExplorationConfig",
    "LearnerConfig",
    "NetworkConfig",
    "OnlineConfig",
    "TrainConfig",
    "TrainingWorld",
    "ValidationConfig",
]

MOST_WORLDS = 64

_OTHER_VERSION = "configuration: not one of this version"
Motion = Literal["sideways", "turning"]


def eye_of_today() -> RetinaSpec:
    """The eye of a policy that is trained anew: no post slips between two of its rays."""
    return RetinaSpec(beams=BeamRule.SECTOR_MINIMUM)


@dataclass(frozen=True)
class ValidationConfig:
    """Validation: how often, and in how many worlds, the greedy policy is measured during a run."""

    points: int = 20
    """Validation points, at equal distances in steps; the last is at the end of the run."""
    agents: int = 256
    """Number of agents, each in a validation world of its own."""
    steps: int = 300
    """World steps of each agent that are counted."""
    discard: int = 50
    """World steps before them that are not counted."""
    stop_at: float | None = None
    """Contacts per 100 m; the run ends when two points in a row have no more. None: never."""

    def __post_init__(self) -> None:
        require(1 <= self.points <= 10_000, "validation.points", "1 to 10000", self.points)
        require(self.agents >= 1, "validation.agents", "1 or more", self.agents)
        require(self.steps >= 1, "validation.steps", "1 or more", self.steps)
        require(self.discard >= 0, "validation.discard", "0 or more", self.discard)
        goal = self.stop_at
        fits = goal is None or 0.0 <= goal < math.inf
        require(fits, "validation.stop_at", "0 or more contacts per 100 m", goal)


@dataclass(frozen=True)
class TrainConfig:
    """A training run."""

    preset: str = "reflex"
    """Name of the preset that this configuration started from."""
    seed: int = 0
    """Seed of the initial weights, the exploration and the training world."""
    steps: int = 500_000
    """Transitions to learn from."""
    worlds: tuple[TrainingWorld, ...] = field(default_factory=lambda: (TrainingWorld(),))
    """The worlds to learn in, one after another. The policy is meant for the last one, and is
    measured there."""
    init_from: str = ""
    """SHA-256 of the policy file that gives the initial weights; "" for new ones from the seed."""
    motion: Motion = "sideways"
    """What the actions left and right do: shift the body sideways, or turn it."""
    forward_mps: float = 1.0
    """Forward speed of every action."""
    lateral_mps: float = 1.0
    """Sideways speed of left and right, if they shift."""
    angular_radps: float = 2.0
    """Turning speed of left and right, if they turn."""
    rate_hz: float = 50.0
    """Rate at which the exported policy is meant to run."""
    max_input_age_s: float = 0.1
    """Age above which the exported policy takes an input for stale. It learns with a sensor that
    sends so late and so seldom: see `embodied.py`."""
    recovery_inputs: int = 3
    """Good inputs in a row before the exported policy may drive."""
    hold_s: float = 0.0
    """For how long the exported policy does an action at least, in seconds. It is validated so."""
    margin: float = 0.0
    """By which share of the spread of the Q-values another action must then win."""
    least_lead: float = 0.0
    """And by how much at least, in the unit of the Q-values."""
    body: BodySpec | None = None
    """The body that it learns with, in every world; None: that of each world. The contract names
    it, or that of the last world."""
    retina: RetinaSpec = field(default_factory=eye_of_today)
    """The eye."""
    network: NetworkConfig = field(default_factory=NetworkConfig)
    """The network."""
    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """The learner."""
    validation: ValidationConfig = field(default_factory=ValidationConfig)
    """The validation during the run."""

    def __post_init__(self) -> None:
        require(0 <= self.seed < 1 << 63, "seed", "0 to 2^63 - 1", self.seed)
        require(self.steps >= 1, "steps", "1 or more", self.steps)
        require(
            self.learner.form == "batched" or len(self.network.hidden) == 1,
            "network.hidden",
            "one layer with learner.form = 'online' (deeper ones learn with 'batched')",
            self.network.hidden,
        )
        require_one_of(Motion, "motion", self.motion)
        outline = self.body.footprint if self.body is not None else Footprint()
        round_one = outline == Footprint(radius_m=outline.radius_m)
        require(round_one, "body.footprint", "a radius: bodies are round here", outline)
        require(1 <= len(self.worlds) <= MOST_WORLDS, "worlds", "1 to 64", len(self.worlds))
        require(0.0 <= self.hold_s <= 3600.0, "hold_s", "in [0, 3600]", self.hold_s)
        require_share("margin", self.margin)
        lead = self.least_lead
        require(0.0 <= lead < math.inf, "least_lead", "0 or more, and finite", lead)
        for name in ("forward_mps", "lateral_mps", "angular_radps"):
            speed = getattr(self, name)
            require(0.0 < speed < math.inf, name, "positive", speed)

    @property
    def goal(self) -> TrainingWorld:
        """The world that the policy is meant for: the last one."""
        return self.worlds[-1]

    @property
    def goal_world(self) -> WorldSource:
        """The world that the policy is meant for, as the simulation takes it."""
        return self.source_of(self.goal)

    def source_of(self, world: TrainingWorld) -> WorldSource:
        """A world with the body and the sensor of this run, as the simulation takes it."""
        return embodied(world.source(), self.body, self.max_input_age_s)

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
    def from_resolved(cls, document: object) -> Self:
        """Read back what `resolved` wrote.

        Args:
            document: a mapping, as JSON gives it.

        Raises:
            UsageError: it is none, or a field is missing, unknown or out of range.
        """
        if not isinstance(document, Mapping):
            got = type(document).__name__
            raise UsageError(f"{_OTHER_VERSION} (expected a mapping, got {got}); train anew")
        source = MappingSource(as_of_today(document), "configuration")
        try:
            require_parts(source)
            return fill(cls, source)
        except ReflexarcError as error:
            raise UsageError(f"{_OTHER_VERSION} ({error}); train anew") from None

    def contract(self, provenance: Provenance | None = None) -> PolicyContract:
        """What the policy of this run sees and does."""
        return PolicyContract(
            retina=self.retina,
            actions=self._actions(),
            rate_hz=self.rate_hz,
            max_input_age_s=self.max_input_age_s,
            recovery_inputs=self.recovery_inputs,
            hold_s=self.hold_s,
            margin=self.margin,
            least_lead=self.least_lead,
            body=self._body(),
            provenance=provenance or Provenance(),
        )

    def _body(self) -> BodySpec:
        """The body that the contract names; worlds of a family have no body in common."""
        if self.body is not None:
            return self.body
        world = self.goal.source()
        return world.body if isinstance(world, World) else BodySpec()

    def _actions(self) -> tuple[Action, ...]:
        if self.motion == "turning":
            return turning_actions(self.forward_mps, self.angular_radps)
        return sideways_actions(self.forward_mps, self.lateral_mps)


def turning_actions(forward_mps: float, angular_radps: float) -> tuple[Action, ...]:
    """Stay, left and right at constant forward speed, for a body that turns."""
    return (
        Action("stay", forward_mps, 0.0),
        Action("left", forward_mps, 0.0, angular_radps),
        Action("right", forward_mps, 0.0, -angular_radps),
    )
