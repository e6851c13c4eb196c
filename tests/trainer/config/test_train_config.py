"""Configurations: checked, hashed, written and read back; presets by name."""

import dataclasses
import json
import math
from typing import Any

import pytest

from reflexarc_runtime.contract import Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.presets import HELP, PRESETS, preset_named
from reflexarc_trainer.config.train_config import (
    BatchedConfig,
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
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


PARTS: dict[str, Any] = {
    "network": NetworkConfig,
    "learner": LearnerConfig,
    "exploration": ExplorationConfig,
    "learner.online": OnlineConfig,
    "learner.batched": BatchedConfig,
}


@pytest.mark.parametrize(
    ("part", "field", "value"),
    [
        ("learner", "trace_decay", 1.1),
        ("learner", "gamma", 1.0),
        ("learner", "reward_contact", math.inf),
        ("learner", "reward_centring", -0.1),
        ("learner", "averaged_weights", 1.0),
        ("learner", "form", "offline"),
        ("learner", "target", "largest"),
        ("network", "hidden", 0),
        ("network", "hidden", ()),
        ("network", "hidden", (8, 8, 8, 8)),
        ("network", "hidden", (8, 2.5)),
        ("network", "units", "softplus"),
        ("network", "output", "softmax"),
        ("network", "input_power", 1.5),
        ("exploration", "epsilon_end", -0.1),
        ("exploration", "held_actions", 0),
        ("learner.online", "alpha", 0.0),
        ("learner.online", "alpha", math.nan),
        ("learner.online", "alpha_end", 2.0),
        ("learner.online", "kappa", 0.5),
        ("learner.online", "step", "large"),
        ("learner.batched", "agents", 100),
        ("learner.batched", "rollout_steps", 0),
        ("learner.batched", "minibatches", 17),
        ("learner.batched", "optimiser", "sgd"),
        ("learner.batched", "learning_rate", math.nan),
        ("learner.batched", "max_gradient_norm", 0.0),
        ("learner.batched", "precision", "float16"),
    ],
)
def test_impossible_value_is_refused_by_the_name_of_its_field(
    part: str, field: str, value: Any
) -> None:
    with pytest.raises(UsageError, match=rf"{part}\.{field}: expected .*, got") as refusal:
        PARTS[part](**{field: value})
    assert "\n" not in str(refusal.value)


def test_plain_number_of_hidden_units_is_one_layer() -> None:
    assert NetworkConfig(hidden=12).hidden == (12,)  # type: ignore[arg-type]  # what old files say


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


def test_unknown_preset_is_refused_and_the_known_are_listed() -> None:
    with pytest.raises(
        UsageError,
        match=f"'reflexes'; known: {', '.join(PRESETS)}",
    ):
        preset_named("reflexes")


def test_every_preset_has_a_help_and_carries_its_name() -> None:
    assert set(HELP) == set(PRESETS)
    assert all(HELP[name] and config.preset == name for name, config in PRESETS.items())


def test_paper_preset_is_the_papers_learner_and_its_literal_eye() -> None:
    paper = preset_named("paper")
    learner = paper.learner
    assert (learner.online.alpha, learner.trace_decay, learner.gamma) == (0.5, 0.9, 0.9)
    sizes = (paper.retina.rays, *paper.network.hidden, len(paper.contract().actions))
    assert sizes == (16, 10, 3)
    assert (learner.reward_step, learner.reward_contact) == (0.1, -1.0)
    assert paper.retina.shading is Shading.COLOUR


def test_configuration_of_an_older_version_reads_with_the_defaults_of_later_fields() -> None:
    document = TrainConfig().resolved()
    del document["retina"]["samples"], document["learner"]["averaged_weights"], document["motion"]
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
