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


@pytest.mark.parametrize(("field", "value"), [("seed", -1), ("steps", 0), ("lateral_mps", 0.0)])
def test_impossible_run_is_refused_by_the_name_of_its_field(field: str, value: Any) -> None:
    with pytest.raises(UsageError, match=rf"{field}: expected"):
        TrainConfig(**{field: value})


@pytest.mark.parametrize("change", [{"colour": 1}, {"learner": {"omega": 1}}, {"retina": {}}])
def test_configuration_of_another_version_is_refused(change: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="configuration: not one of this version"):
        TrainConfig.from_resolved({**TrainConfig().resolved(), **change})
