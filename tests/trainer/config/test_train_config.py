"""Configurations of runs: checked, hashed, written and read back."""

import dataclasses
import json
from typing import Any

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import (
    LearnerConfig,
    NetworkConfig,
    TrainConfig,
    ValidationConfig,
)


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


def test_online_form_refuses_a_deep_network_and_says_which_form_takes_it() -> None:
    with pytest.raises(UsageError, match=r"network\.hidden: expected one layer .*'batched'"):
        TrainConfig(network=NetworkConfig(hidden=(8, 8)))


def test_holds_stand_in_the_contract() -> None:
    contract = TrainConfig(hold_s=0.1, margin=0.2, least_lead=0.03).contract()
    assert (contract.hold_s, contract.margin, contract.least_lead) == (0.1, 0.2, 0.03)
    assert not TrainConfig().contract().keeps_actions


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("seed", -1),
        ("steps", 0),
        ("lateral_mps", 0.0),
        ("hold_s", -1.0),
        ("margin", 1.1),
        ("least_lead", float("inf")),
    ],
)
def test_impossible_run_is_refused_by_the_name_of_its_field(field: str, value: Any) -> None:
    with pytest.raises(UsageError, match=rf"{field}: expected"):
        TrainConfig(**{field: value})


@pytest.mark.parametrize("change", [{"colour": 1}, {"learner": {"omega": 1}}, {"retina": {}}])
def test_configuration_of_another_version_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="configuration: not one of this version"):
        TrainConfig.from_resolved({**TrainConfig().resolved(), **change})


def test_configuration_of_an_older_version_reads_with_the_defaults_of_later_fields() -> None:
    document = TrainConfig().resolved()
    del document["retina"]["samples"], document["learner"]["averaged_weights"], document["motion"]
    del document["hold_s"], document["margin"], document["least_lead"]
    del document["learner"]["reward_switch"], document["learner"]["exploration"]["margin"]
    del document["learner"]["exploration"]["least_lead"]
    document["network"]["hidden"] = 10
    assert TrainConfig.from_resolved(document) == TrainConfig()


@pytest.mark.parametrize(
    ("part", "change", "words"),
    [
        ("learner", {"gamma": "high"}, "configuration.learner.gamma: expected a number"),
        ("learner", {"gamma": 1.5}, r"configuration.learner.gamma: expected in \[0, 1\)"),
        ("retina", {"shading": "loud"}, "retina.shading: expected colour or nearness"),
        ("network", {"units": "step"}, "network.units: expected one of sigmoid, tanh, relu"),
    ],
)
def test_a_field_of_another_version_is_named_by_its_path(
    part: str, change: dict[str, Any], words: str
) -> None:
    document = TrainConfig().resolved()
    with pytest.raises(UsageError, match=words):
        TrainConfig.from_resolved({**document, part: {**document[part], **change}})
