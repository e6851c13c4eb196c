"""A unit of a study (one run: a configuration with a seed, and how it is measured) and its result.

`measuring.py` computes the result of a unit. Both can be written as JSON, to send them to worker
processes and to keep them in files.
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
    """The quantity that a study measures."""

    CONTACTS = "contacts"
    """Contacts per 100 m of the greedy policy."""
    SHARE_OF_BLIND = "share_of_blind"
    """Contacts as a share of those of an agent that never steers, in the same worlds."""
    EDGE_INDEX = "edge_index"
    """Share of the time near a side of the world, divided by that of uniformly placed agents."""
    SUITE = "suite"
    """Headline score in the lite suite, at ten decisions a second and as a point: 0 for an agent
    that never steers, 1 for one that knows everything."""


@dataclass(frozen=True)
class Evaluation:
    """How a greedy policy is measured: numbers of agents and steps, in worlds of test seeds.

    `reflexarc evaluate` takes 4,096 agents and 2,000 steps, for the report on a single policy. In a
    study seeds differ by a tenth, and contacts measured to within 2 % are enough.
    """

    agents: int = 1024
    """Number of agents, each in a world of its own."""
    steps: int = 1000
    """World steps of each agent that are counted."""
    discard: int = 100
    """World steps before them that are not counted; as many as in the reference field."""
    world: str = ""
    """Name or file of the world; by default the last one that the run learns in."""

    def __post_init__(self) -> None:
        require(1 <= self.agents <= MOST_AGENTS, "agents", f"1 to {MOST_AGENTS}", self.agents)
        require(1 <= self.steps <= MOST_STEPS, "steps", f"1 to {MOST_STEPS}", self.steps)
        require(0 <= self.discard <= MOST_STEPS, "discard", f"0 to {MOST_STEPS}", self.discard)


@dataclass(frozen=True)
class Unit:
    """One run of a study: what is learned, and how it is measured."""

    config: TrainConfig
    evaluation: Evaluation = field(default_factory=Evaluation)
    measure: Measure = Measure.CONTACTS
    world: TrainingWorld | None = None
    """The world that it is measured in, with the text of its file; set on construction."""

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
        """The unit as plain JSON values."""
        rest: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(self)))
        return {**rest, "config": self.config.resolved()}

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """Read back what `to_plain` returned.

        Raises:
            UsageError: it is not a unit of this version.
        """
        try:
            return fill(cls, MappingSource(document, "unit"), require_all=True)
        except ReflexarcError as error:
            raise UsageError(f"unit: not one of this version ({error})") from None

    @property
    def hash(self) -> str:
        """SHA-256, in hexadecimal, of the unit's canonical JSON."""
        text = json.dumps(self.to_plain(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Result:
    """The result of a unit. All figures are None if the weights diverged."""

    unit: str
    """Hash of the unit."""
    code: str
    """Hash of the code that computed it: see `code_key`."""
    diverged: bool
    """Whether the weights became infinite or NaN."""
    steps: int
    """Transitions learned from."""
    learning_s: float
    """Wall-clock time of learning, including compilation if there was any."""
    evaluation_s: float
    contacts_per_100m: float | None = None
    share_of_blind: float | None = None
    """None also if an agent that never steers has no contacts."""
    edge_index: float | None = None
    """None also if it is not the study's measure."""
    blind_per_100m: float | None = None
    """Contacts of an agent that never steers, in the same worlds; None in results of before."""
    suite_score: float | None = None
    """None also if it is not the study's measure."""
    weights_hash: str = ""
    """SHA-256 of the learned weights as float64."""

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """Read back what `dataclasses.asdict` gave of one.

        Raises:
            UsageError: it is none of this version.
        """
        return fill(cls, MappingSource(document, "result"))

    def figure(self, measure: Measure) -> float | None:
        """The figure of a measure."""
        return {
            Measure.CONTACTS: self.contacts_per_100m,
            Measure.SHARE_OF_BLIND: self.share_of_blind,
            Measure.EDGE_INDEX: self.edge_index,
            Measure.SUITE: self.suite_score,
        }[measure]

    @property
    def blind(self) -> float | None:
        """Contacts per 100 m of an agent that never steers, also where only a share was kept."""
        if self.blind_per_100m is None and self.contacts_per_100m and self.share_of_blind:
            return self.contacts_per_100m / self.share_of_blind
        return self.blind_per_100m


@lru_cache(maxsize=1)
def code_key() -> str:
    """Hash of the sources and package versions that a figure may depend on."""
    text = json.dumps([source_key(_SOURCES), versions()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
