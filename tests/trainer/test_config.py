"""Configurations: checked, hashed, written and read back; presets by name."""

import dataclasses
import json
import math
from typing import Any

import pytest

from reflexarc_runtime.contract import Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config import LearnerConfig, TrainConfig, ValidationConfig
from reflexarc_trainer.presets import HELP, PRESETS, preset_named


@pytest.mark.parametrize("name", PRESETS)
def test_resolved_configuration_reads_back_the_same(name: str) -> None:
    config = PRESETS[name]
    text = json.dumps(config.resolved())
    assert TrainConfig.from_resolved(json.loads(text)) == config
    assert TrainConfig.from_resolved(json.loads(text)).hash == config.hash


def test_hash_changes_with_any_field() -> None:
    config = TrainConfig()
    others = [
        dataclasses.replace(config, seed=1),
        dataclasses.replace(config, learner=LearnerConfig(gamma=0.8)),
        dataclasses.replace(config, validation=ValidationConfig(points=3)),
    ]
    assert len({c.hash for c in [config, *others]}) == 4


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("alpha", 0.0),
        ("alpha", math.nan),
        ("trace_decay", 1.1),
        ("gamma", 1.0),
        ("kappa", 0.5),
        ("hidden", 0),
        ("epsilon_end", -0.1),
        ("held_actions", 0),
        ("reward_contact", math.inf),
        ("step", "large"),
        ("output", "softmax"),
    ],
)
def test_impossible_learner_is_refused_by_the_name_of_its_field(field: str, value: Any) -> None:
    with pytest.raises(UsageError, match=rf"learner\.{field}: expected .*, got"):
        LearnerConfig(**{field: value})


@pytest.mark.parametrize(("field", "value"), [("seed", -1), ("steps", 0), ("lateral_mps", 0.0)])
def test_impossible_run_is_refused_by_the_name_of_its_field(field: str, value: Any) -> None:
    with pytest.raises(UsageError, match=rf"{field}: expected"):
        TrainConfig(**{field: value})


@pytest.mark.parametrize("change", [{"colour": 1}, {"learner": {"omega": 1}}, {"retina": {}}])
def test_configuration_of_another_version_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="configuration: not one of this version"):
        TrainConfig.from_resolved({**TrainConfig().resolved(), **change})


def test_unknown_preset_is_refused_and_the_known_are_listed() -> None:
    with pytest.raises(UsageError, match=r"'reflexes'; known: reflex, lidar, paper"):
        preset_named("reflexes")


def test_every_preset_has_a_help_and_carries_its_name() -> None:
    assert set(HELP) == set(PRESETS)
    assert all(HELP[name] and config.preset == name for name, config in PRESETS.items())


def test_paper_preset_is_the_papers_learner_and_its_literal_eye() -> None:
    paper = preset_named("paper")
    learner = paper.learner
    assert (learner.alpha, learner.trace_decay, learner.gamma) == (0.5, 0.9, 0.9)
    assert (paper.retina.rays, learner.hidden, len(paper.contract().actions)) == (16, 10, 3)
    assert (learner.reward_step, learner.reward_contact) == (0.1, -1.0)
    assert paper.retina.shading is Shading.COLOUR
