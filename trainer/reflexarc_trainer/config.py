"""What a training run is made of: nested frozen dataclasses, checked on construction.

Network and learner are in `learner_config.py`. Schedules count steps, never seconds.
"""

import dataclasses
import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from reflexarc_runtime.contract import (
    PolicyContract,
    Provenance,
    RetinaSpec,
    Shading,
    sideways_actions,
)
from reflexarc_runtime.errors import ContractError, UsageError
from reflexarc_trainer.checks import require
from reflexarc_trainer.learner_config import (
    BatchedConfig,
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
)

__all__ = [
    "BatchedConfig",
    "ExplorationConfig",
    "LearnerConfig",
    "NetworkConfig",
    "OnlineConfig",
    "TrainConfig",
    "ValidationConfig",
]


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
        require(1 <= self.points <= 10_000, "validation.points", "1 to 10000", self.points)
        require(self.agents >= 1, "validation.agents", "1 or more", self.agents)
        require(self.steps >= 1, "validation.steps", "1 or more", self.steps)
        require(self.discard >= 0, "validation.discard", "0 or more", self.discard)


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
    network: NetworkConfig = field(default_factory=NetworkConfig)
    """The network."""
    learner: LearnerConfig = field(default_factory=LearnerConfig)
    """The learner."""
    validation: ValidationConfig = field(default_factory=ValidationConfig)
    """The measurements on the way."""

    def __post_init__(self) -> None:
        require(0 <= self.seed < 1 << 63, "seed", "0 to 2^63 - 1", self.seed)
        require(self.steps >= 1, "steps", "1 or more", self.steps)
        require(
            self.learner.form == "batched" or len(self.network.hidden) == 1,
            "network.hidden",
            "one layer with learner.form = 'online' (deeper ones learn with 'batched')",
            self.network.hidden,
        )
        for name in ("forward_mps", "lateral_mps"):
            speed_mps = getattr(self, name)
            require(0.0 < speed_mps < math.inf, name, "positive", speed_mps)

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
                "network": NetworkConfig(**document["network"]),
                "learner": _learner(document["learner"]),
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


def _learner(document: Mapping[str, Any]) -> LearnerConfig:
    parts = {
        "exploration": ExplorationConfig(**document["exploration"]),
        "online": OnlineConfig(**document["online"]),
        "batched": BatchedConfig(**document["batched"]),
    }
    return LearnerConfig(**{**document, **parts})
