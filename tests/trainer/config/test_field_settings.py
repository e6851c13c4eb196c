"""Any field of a training configuration is set by its dotted name, or refused by it."""

from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass, replace
from typing import Any

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_trainer.config.field_settings import with_settings
from reflexarc_trainer.config.presets import PRESETS, preset_named
from reflexarc_trainer.config.train_config import LearnerConfig, OnlineConfig, TrainConfig


def leaves(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def test_each_field_takes_back_what_the_resolved_configuration_says() -> None:
    """All that `config.json` shows can be set; worlds are written in words of their own."""
    config = replace(preset_named("rover"), body=BodySpec(Footprint(0.3), 0.1, 2.0))
    resolved = dict(leaves(config.resolved()))
    settings = {name: value for name, value in resolved.items() if name != "worlds"}
    assert len(settings) > 50
    written = {name: "none" if v is None else v for name, v in settings.items()}
    base = replace(TrainConfig(), worlds=config.worlds)
    assert with_settings(base, written) == config


def test_fields_are_set_deep_inside_and_nothing_else_changes() -> None:
    changed = with_settings(TrainConfig(), {"learner.online.alpha": 0.3, "learner.gamma": 0.8})
    assert changed == TrainConfig(learner=LearnerConfig(gamma=0.8, online=OnlineConfig(alpha=0.3)))


def test_what_is_not_said_of_a_body_is_as_in_the_last_world() -> None:
    """The order of settings does not matter: `rover` has a disc of 0.2 m, lag 0.1 s, 2 m/s²."""
    settings = {"body.actuation_delay_s": 0.3, "worlds": ["reference-1", "rover"]}
    expected = BodySpec(Footprint(0.2), 0.3, 2.0)
    assert with_settings(preset_named("reflex"), settings).body == expected
    turned = dict(reversed(settings.items()))
    assert with_settings(preset_named("reflex"), turned).body == expected


@pytest.mark.parametrize(
    ("name", "value", "complaint"),
    [
        ("learner.gama", 1, "learner.gama: no such field; nearest: learner.gamma"),
        ("alpha", 1, "alpha: no such field; nearest: learner.online.alpha; known: preset"),
        ("body.radius_m", 1, "body.radius_m: no such field; nearest: body.footprint.radius_m"),
        ("rayz", 1, "rayz: no such field; nearest: retina.rays"),
        ("", 1, ": no such field; known"),
        ("learner.online", 1, "learner.online: expected one of its fields: alpha, "),
        ("body", 1, "body: expected one of its fields: footprint, "),
        ("learner.online.alpha", "abc", "learner.online.alpha: expected a number, got 'abc'"),
        ("learner.online.alpha", "none", "learner.online.alpha: expected a number, got 'none'"),
        ("validation.agents", 1e3, "validation.agents: expected a whole number, got 1000.0"),
        ("learner.form", "batch", "learner.form: expected online or batched, got 'batch'"),
        ("worlds", 9, "worlds: expected a text, got 9"),
        ("body.footprint.radius_m", -1, "body.footprint: expected sizes from 0 on, got -1"),
        ("body.actuation_delay_s", -1, "body.actuation_delay_s: expected 0 or more, got -1"),
        ("learner.exploration.margin", 2, "learner.exploration.margin: expected in"),
        ("learner.online.alpha", float("nan"), "learner.online.alpha: expected in"),
    ],
)
def test_a_complaint_begins_with_the_whole_name(name: str, value: object, complaint: str) -> None:
    with pytest.raises(ReflexarcError) as caught:
        with_settings(TrainConfig(), {name: value})
    assert str(caught.value).startswith(complaint)


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_nothing_set_is_the_preset_itself(preset: str) -> None:
    config = preset_named(preset)
    assert is_dataclass(config)
    assert with_settings(config, {}) == config
