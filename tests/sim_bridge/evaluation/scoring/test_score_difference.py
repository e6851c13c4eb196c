"""Differences of scores, worked out by hand: paired over worlds, apart over seeds."""

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval
from reflexarc_sim_bridge.evaluation.scoring.score_difference import score_differences
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards
from support.suite_results import BLIND, agent, results_of


def width(interval: Interval) -> float:
    assert interval.low is not None
    assert interval.high is not None
    return interval.high - interval.low


def of_two(results: Results) -> tuple[Interval, dict[str, Interval]]:
    first, second = score_cards(results)
    return score_differences(results, first, second)


def test_differences_are_those_of_the_scores_and_the_headline_is_their_mean() -> None:
    results = results_of(
        {
            BLIND: {"a/1": [10, 10], "b/1": [10, 10]},
            "mine": {"a/1": [2, 2], "b/1": [6, 6]},
            "other": {"a/1": [5, 5], "b/1": [5, 5]},
        },
        [agent("mine"), agent("other")],
    )
    headline, families = of_two(results)
    assert families["a"].value == pytest.approx(0.3)
    assert families["b"].value == pytest.approx(-0.1)
    assert headline.value == pytest.approx(0.1)


def test_what_worlds_do_to_both_is_no_part_of_the_difference() -> None:
    counts = np.random.default_rng(1).poisson(30, 40).astype(float)
    results = results_of(
        {
            BLIND: {"a/1": [100.0] * 40},
            "mine": {"a/1": counts.tolist()},
            "other": {"a/1": (counts + 7.0).tolist()},
        },
        [agent("mine"), agent("other")],
    )
    headline, families = of_two(results)
    assert width(score_cards(results)[0].headline) > 0.02
    assert families["a"].value == pytest.approx(0.07)
    assert width(headline) == pytest.approx(0.0, abs=1e-12)


def test_the_interval_is_that_of_differences_world_by_world() -> None:
    """1.96 standard errors of the mean difference on either side."""
    generator = np.random.default_rng(2)
    mine, other = (generator.poisson(mean, 60).astype(float) for mean in (30, 40))
    results = results_of(
        {BLIND: {"a/1": [100.0] * 60}, "mine": {"a/1": mine}, "other": {"a/1": other}},
        [agent("mine"), agent("other")],
    )
    error = np.std(mine - other, ddof=1) / np.sqrt(60) / 100.0
    assert width(of_two(results)[0]) == pytest.approx(2 * 1.96 * error, rel=0.1)


def test_seeds_of_two_presets_are_drawn_apart() -> None:
    """Equal presets of eight seeds: the variance of the difference is twice that of one."""
    names = {f"{preset}{seed}": seed for preset in "pq" for seed in range(8)}
    contacts = {BLIND: {"a/1": [100.0] * 4}}
    contacts |= {name: {"a/1": [10.0 * (seed + 1)] * 4} for name, seed in names.items()}
    agents = [agent(name, seed=seed, group=name[0]) for name, seed in names.items()]
    results = results_of(contacts, agents)
    first, second = score_cards(results)[-2:]
    headline, _ = score_differences(results, first, second)
    assert headline.value == 0.0
    assert width(headline) == pytest.approx(np.sqrt(2.0) * width(first.headline), rel=0.1)


def test_of_three_seeds_there_is_no_interval() -> None:
    contacts = {BLIND: {"a/1": [100.0] * 4}, "mine": {"a/1": [10.0] * 4}}
    contacts |= {f"s{seed}": {"a/1": [20.0] * 4} for seed in range(3)}
    agents = [agent("mine"), *(agent(f"s{seed}", seed=seed, group="s") for seed in range(3))]
    results = results_of(contacts, agents)
    cards = score_cards(results)
    headline, _ = score_differences(results, cards[0], cards[-1])
    assert (headline.value, headline.low, headline.high) == (pytest.approx(0.1), None, None)


def test_cards_without_a_common_family_cannot_be_compared() -> None:
    one = results_of({BLIND: {"a/1": [9, 9]}, "mine": {"a/1": [1, 1]}}, [agent("mine")])
    two = results_of({BLIND: {"b/1": [9, 9]}, "other": {"b/1": [1, 1]}}, [agent("other")])
    both = Results(
        "made-up-1",
        "0",
        [*one.agents, *two.agents],
        [*one.rows, *two.rows],
        [*one.limits, *two.limits],
        [*one.cells, *two.cells],
    )
    with pytest.raises(UsageError, match="mine and other share, got none"):
        of_two(both)
