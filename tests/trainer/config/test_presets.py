"""Presets by name; the paper's numbers in the preset of that name."""

import pytest

from reflexarc_runtime.contract.eye import Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.presets import HELP, HOLD_S, LEAST_LEAD, PRESETS, preset_named


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


def test_presets_for_50_hz_ship_the_knee_and_no_others_do() -> None:
    """At 10 Hz there is little chatter, and each lead costs contacts; the paper knows none."""
    contracts = {name: config.contract() for name, config in PRESETS.items()}
    leading = {name for name, contract in contracts.items() if contract.keeps_actions}
    assert leading == {"reflex", "binocular", "rover", "reflex-online"}
    assert all(contracts[name].rate_hz == 50.0 for name in leading)
    kept = {(contracts[name].hold_s, contracts[name].least_lead) for name in leading}
    assert kept == {(HOLD_S, LEAST_LEAD)}
