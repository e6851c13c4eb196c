"""One unit of a study's work and what it gave; `measuring.py` goes from one to the other.

Both are plain JSON, so that they can be sent anywhere.
"""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from typing import Any, Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_sim_bridge.native.cache import source_key
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import TrainingWorld
from reflexarc_trainer.policy.provenance import versions

_SOURCES = "reflexarc_runtime/", "reflexarc_sim_bridge/", "reflexarc_trainer/"
MOST_AGENTS, MOST_STEPS = 1 << 16, 1 << 20


class Measure(StrEnum):
    """The figure of a study."""

    CONTACTS = "contacts"
    """Contacts per 100 m of the greedy policy."""
    SHARE_OF_BLIND = "share_of_blind"
    """The same as a share of what an agent that never steers has in the same worlds."""
    EDGE_INDEX = "edge_index"
    """Share of the time near a side ÷ what it is for an agent that is anywhere alike."""


@dataclass(frozen=True)
class Evaluation:
    """On how much a greedy policy is measured, and where. The worlds are those of test seeds.

    `reflexarc evaluate` takes 4,096 agents and 2,000 steps, for reports on one policy. Among seeds
    that differ by a tenth, contacts that are known to 2 % are enough.
    """

    agents: int = 1024
    """Agents, each in a world of its own."""
    steps: int = 1000
    """Counted steps of each."""
    discard: int = 100
    """Steps before them that do not count; as many as in the reference field."""
    world: str = ""
    """Where, a name or a file; by default in the last world that was learned in."""

    def __post_init__(self) -> None:
        require(1 <= self.agents <= MOST_AGENTS, "agents", f"1 to {MOST_AGENTS}", self.agents)
        require(1 <= self.steps <= MOST_STEPS, "steps", f"1 to {MOST_STEPS}", self.steps)
        require(0 <= self.discard <= MOST_STEPS, "discard", f"0 to {MOST_STEPS}", self.discard)


@dataclass(frozen=True)
class Unit:
    """What is to be learned and how it is measured."""

    config: TrainConfig
    evaluation: Evaluation = field(default_factory=Evaluation)
    measure: Measure = Measure.CONTACTS
    world: TrainingWorld | None = None
    """Where it is measured, as text; filled in."""

    def __post_init__(self) -> None:
        require(
            self.config.motion == "sideways",
            "motion",
            "sideways: contacts are counted over progress along x, which a body that turns has not",
            self.config.motion,
        )
        if self.world is None:
            name = self.evaluation.world
            goal = TrainingWorld(name) if name else self.config.goal
            object.__setattr__(self, "world", dataclasses.replace(goal, share=1.0))

    def to_plain(self) -> dict[str, Any]:
        """As plain JSON values."""
        rest: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(self)))
        return {**rest, "config": self.config.resolved()}

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """Read back what `to_plain` gave.

        Raises:
            UsageError: it is none of this version.
        """
        try:
            return fill(cls, MappingSource(document, "unit"), require_all=True)
        except ReflexarcError as error:
            raise UsageError(f"unit: not one of this version ({error})") from None

    @property
    def hash(self) -> str:
        """SHA-256, in hexadecimal, of its canonical JSON."""
        text = json.dumps(self.to_plain(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Result:
    """What a unit gave. Figures are None where the weights did not stay finite."""

    unit: str
    """Hash of the unit."""
    code: str
    """Of what the figures come from: see `code_key`."""
    diverged: bool
    steps: int
    """Transitions learned from."""
    learning_s: float
    """Wall-clock time of learning, compilation included where there was any."""
    evaluation_s: float
    contacts_per_100m: float | None = None
    share_of_blind: float | None = None
    """None, too, where an agent that never steers meets nothing."""
    edge_index: float | None = None
    """None, too, where it is not the study's measure."""
    weights_hash: str = ""
    """SHA-256 of what was learned, as float64."""

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """Read back what `dataclasses.asdict` gave of one.

        Raises:
            UsageError: it is none of this version.
        """
        return fill(cls, MappingSource(document, "result"))

    def figure(self, measure: Measure) -> float | None:
        """The figure that a study is about."""
        if measure is Measure.CONTACTS:
            return self.contacts_per_100m
        return self.share_of_blind if measure is Measure.SHARE_OF_BLIND else self.edge_index


@lru_cache(maxsize=1)
def code_key() -> str:
    """Hash over the sources and the versions of the packages that a figure may depend on."""
    text = json.dumps([source_key(_SOURCES), versions()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
