import dataclasses

import numpy as np
import pytest

from reflexarc_baselines import search as searching
from reflexarc_baselines.anchors.three_motions import ThreeMotions
from reflexarc_baselines.baseline import Span
from reflexarc_baselines.registry import HOMES, baseline_named
from reflexarc_baselines.search import SearchBudget, drawn_settings, search, with_setting
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

SMALL = SearchBudget(trials=3, agents=16, steps=20)


def test_every_baseline_gets_the_same_budget() -> None:
    assert SearchBudget() == SearchBudget(trials=64, agents=256, steps=200)


@pytest.mark.parametrize("name", [n for n in HOMES if baseline_named(n).SEARCHED])
def test_what_ships_lies_within_what_is_searched_and_every_draw_is_a_baseline(name: str) -> None:
    baseline = baseline_named(name)
    for parameter, span in baseline.SEARCHED.items():
        assert span.low <= getattr(baseline, parameter) <= span.high, parameter
    for setting in drawn_settings(baseline.SEARCHED, 20, 1):
        made = with_setting(baseline, setting)
        assert {name: getattr(made, name) for name in setting} == setting


def test_draws_are_even_in_their_own_measure() -> None:
    spans = {
        "even": Span(2.0, 4.0),
        "log": Span(1e-2, 1e2, is_log=True),
        "whole": Span(1, 3, is_whole=True),
    }
    drawn = drawn_settings(spans, 3000, 0)
    even, log, whole = (np.array([setting[name] for setting in drawn]) for name in spans)
    assert (even.min() >= 2.0, even.max() <= 4.0) == (True, True)
    assert abs((even < 3.0).mean() - 0.5) < 0.04
    assert (log.min() >= 1e-2, log.max() <= 1e2) == (True, True)
    assert abs((log < 1.0).mean() - 0.5) < 0.04
    assert {number: round(float((whole == number).mean()), 1) for number in (1, 2, 3)} == {
        1: 0.3,
        2: 0.3,
        3: 0.3,
    }
    assert all(type(setting["whole"]) is int for setting in drawn)


def test_the_same_seed_gives_the_same_table_and_another_another() -> None:
    first = search("three-motions", budget=SMALL)
    assert search("three-motions", budget=SMALL) == first
    assert search("three-motions", budget=SMALL, seed=1).trials != first.trials


def test_a_trial_is_what_measuring_its_setting_on_validation_worlds_gives() -> None:
    report = search("three-motions", budget=SMALL)
    rates = [trial.contacts_per_100m for trial in report.trials]
    assert rates == sorted(rates)
    assert len(report.trials) == 3
    assert report.shipped.setting == {"rays": 2, "preference_m": 0.0224}
    for trial in (report.shipped, *report.trials):
        policy = dataclasses.replace(ThreeMotions(), **trial.setting)  # type: ignore[arg-type]  # floats and ints
        score = measure(policy, policy.contract, agents=16, steps=20, seeds=validation_seeds(16))
        assert trial.contacts_per_100m == score.contacts_per_100m


def test_a_range_finder_is_searched_in_a_white_world(monkeypatch: pytest.MonkeyPatch) -> None:
    """One sees ranges, the other colours: in a dim world what is dark is near to the first only."""
    worlds = {}

    def looked_at(policy: object, *_: object, world: object, **__: object) -> object:
        worlds[type(policy).__name__] = world.drawn(0)  # type: ignore[attr-defined]  # a source
        return type("Score", (), {"contacts_per_100m": 1.0})

    monkeypatch.setattr(searching, "measure", looked_at)
    dim = dataclasses.replace(ThreeMotions.ORIGIN, home_world="dim")
    for name in ("three-motions", "braitenberg-2a"):
        baseline = baseline_named(name)
        origin = dataclasses.replace(baseline.ORIGIN, home_world=dim.home_world)
        monkeypatch.setattr(type(baseline), "ORIGIN", origin)
        searching.rate_of(baseline, SMALL)(baseline)
    colours = {
        name: {getattr(layer, "colour", None) for layer in world.layers}
        for name, world in worlds.items()
    }
    assert colours["ThreeMotions"] != colours["Braitenberg2a"]


def test_what_has_nothing_free_cannot_be_searched() -> None:
    with pytest.raises(UsageError, match="expected a baseline with free parameters, got blind"):
        search("blind")
    with pytest.raises(UsageError, match="none is named 'nobody'"):
        search("nobody")
    with pytest.raises(UsageError, match="expected trials ≥ 1, got 0"):
        SearchBudget(trials=0)
