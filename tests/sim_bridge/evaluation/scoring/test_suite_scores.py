"""Score cards of results that are made up, so that every figure can be worked out by hand."""

import json

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard, middle_means
from reflexarc_sim_bridge.evaluation.scoring.statistics import interquartile_mean
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import presets_of, score_cards
from support.suite_results import BLIND, METRES, ORACLE, agent, results_of


def card_of(results: Results) -> ScoreCard:
    (card,) = score_cards(results)
    return card


def test_scores_run_from_blind_to_no_contact_and_the_headline_is_a_mean_of_families() -> None:
    results = results_of(
        {
            BLIND: {"a/1": [10, 10], "a/2": [20, 20], "b/1": [8, 8]},
            "mine": {"a/1": [5, 5], "a/2": [0, 0], "b/1": [6, 6]},
        },
        [agent("mine")],
    )
    card = card_of(results)
    assert card.families["a"].value == pytest.approx((0.5 + 1.0) / 2)
    assert card.families["b"].value == pytest.approx(0.25)
    assert card.headline.value == pytest.approx((0.75 + 0.25) / 2)
    assert card.worst_family == "b"
    assert card.optimality_gap == pytest.approx((0.25 + 0.75) / 2)
    assert [cell.score.value for cell in card.cells["mine"]] == pytest.approx([0.5, 1.0, 0.25])
    assert card.note == "over 2 worlds"


def test_an_agent_that_never_steers_scores_0_and_one_that_rams_no_less_than_minus_1() -> None:
    results = results_of(
        {
            BLIND: {"a/1": [10, 12]},
            "still blind": {"a/1": [10, 12]},
            "ram": {"a/1": [90, 90]},
        },
        [agent("still blind"), agent("ram")],
    )
    scores = {card.name: card.headline for card in score_cards(results)}
    blind, ram = scores["still blind"], scores["ram"]
    assert (blind.value, blind.low, blind.high) == (0.0, 0.0, 0.0)  # paired: in every draw
    assert ram.value == -1.0


def test_cells_that_do_not_count_stand_beside_the_headline() -> None:
    results = results_of(
        {BLIND: {"a/1": [10, 10], "bees/1": [10, 10]}, "mine": {"a/1": [5, 5], "bees/1": [0, 0]}},
        [agent("mine")],
        uncounted=["bees/1"],
    )
    card = card_of(results)
    assert card.headline.value == pytest.approx(0.5)
    assert list(card.families) == ["a"]
    assert [cell.score.value for cell in card.cells["mine"]] == pytest.approx([0.5, 1.0])


def test_a_cell_in_which_blind_never_collides_tells_nothing() -> None:
    results = results_of(
        {BLIND: {"a/1": [10, 10], "a/2": [0, 0]}, "mine": {"a/1": [5, 5], "a/2": [3, 3]}},
        [agent("mine")],
    )
    assert card_of(results).headline.value == pytest.approx(0.5)


def test_the_robustness_area_is_that_of_the_grid() -> None:
    nominal, one, two = "robustness/none", "robustness/noise", "robustness/slip"
    results = results_of(
        {
            BLIND: {"a/0": [10, 10], nominal: [10, 10], one: [10, 10], two: [10, 10]},
            "mine": {"a/0": [5, 5], nominal: [2, 2], one: [4, 4], two: [8, 8]},
        },
        [agent("mine")],
        uncounted=[nominal, one, two],
    )
    card = card_of(results)
    assert card.robustness_area == pytest.approx(((0.6 + 0.2) / 2) / 0.8)
    assert card.headline.value == pytest.approx(0.5)


def test_an_oracle_that_cannot_avoid_all_is_the_measure_of_the_best() -> None:
    results = results_of(
        {BLIND: {"a/1": [10, 10]}, ORACLE: {"a/1": [2, 2]}, "mine": {"a/1": [4, 4]}},
        [agent("mine")],
    )
    assert card_of(results).headline.value == pytest.approx((10 - 4) / (10 - 2))


def test_who_stands_avoids_nothing() -> None:
    results = results_of({BLIND: {"a/1": [10, 10]}, "idle": {"a/1": [0, 0]}}, [agent("idle")])
    (row,) = results.rows
    row.sums["progress_m"] = [METRES / 20.0] * 2
    assert card_of(results).headline.value == -1.0


def test_a_body_that_turns_is_scored_by_how_far_it_gets() -> None:
    results = results_of(
        {
            BLIND: {"a/1": [3, 3]},
            ORACLE: {"a/1": [60, 60]},
            "rover": {"a/1": [20, 24]},
            "circle": {"a/1": [1, 1]},
        },
        [agent("rover", turns=True), agent("circle", turns=True)],
    )
    rover, circle = score_cards(results)
    assert rover.headline.value == pytest.approx((22.0 - 3.0) / (60.0 - 3.0))
    assert circle.headline.value == pytest.approx((1.0 - 3.0) / (60.0 - 3.0))
    assert rover.cells["rover"][0].contacts_per_100m is None


def preset(seeds: int, *, worlds: int = 8) -> Results:
    """A preset whose seeds score 0.1, 0.2, … in all worlds."""
    names = [f"s{seed}" for seed in range(seeds)]
    contacts = {BLIND: {"a/1": [100.0] * worlds}}
    contacts |= {name: {"a/1": [100.0 - 10.0 * (i + 1)] * worlds} for i, name in enumerate(names)}
    agents = [agent(name, seed=i, group="p@1") for i, name in enumerate(names)]
    return results_of(contacts, agents)


def test_the_seeds_of_a_preset_are_one_interquartile_mean() -> None:
    card = score_cards(preset(8))[-1]
    assert card.name == "p@1, 10 Hz (8 seeds)"
    assert card.headline.value == pytest.approx(np.mean([0.3, 0.4, 0.5, 0.6]))
    assert card.optimality_gap == pytest.approx(np.mean([1 - 0.1 * i for i in range(1, 9)]))
    assert card.note == "over 8 seeds × 8 worlds"
    assert card.headline.low is not None
    assert card.headline.high is not None
    assert card.headline.low < card.headline.value < card.headline.high


def test_the_interval_of_equal_worlds_is_the_bootstrap_over_seeds_alone() -> None:
    card = score_cards(preset(8))[-1]
    generator = np.random.default_rng(7)
    scores = 0.1 * np.arange(1, 9)
    means = [interquartile_mean(generator.choice(scores, 8)) for _ in range(4000)]
    assert card.headline.low == pytest.approx(np.percentile(means, 2.5), abs=0.03)
    assert card.headline.high == pytest.approx(np.percentile(means, 97.5), abs=0.03)


def test_the_interval_of_equal_seeds_is_the_bootstrap_over_worlds_alone() -> None:
    counts = [float(c) for c in np.random.default_rng(3).poisson(30, 40)]
    contacts = {BLIND: {"a/1": [100.0] * 40}, **{f"s{i}": {"a/1": counts} for i in range(5)}}
    agents = [agent(f"s{i}", seed=i, group="p@1") for i in range(5)]
    *singles, card = score_cards(results_of(contacts, agents))
    assert (card.headline.low, card.headline.high) == (
        pytest.approx(singles[0].headline.low),
        pytest.approx(singles[0].headline.high),
    )
    spread = np.std(counts, ddof=1) / 100.0 / np.sqrt(40)
    assert card.headline.high is not None
    assert card.headline.low is not None
    assert card.headline.high - card.headline.low == pytest.approx(2 * 1.96 * spread, rel=0.15)


@pytest.mark.parametrize("seeds", [2, 3])
def test_of_three_seeds_or_fewer_there_is_no_interval(seeds: int) -> None:
    card = score_cards(preset(seeds))[-1]
    assert card.note == f"{seeds} seeds: no interval"
    assert card.headline.low is None
    assert card.headline.high is None


def test_one_seed_twice_is_no_preset() -> None:
    same = [agent("a", seed=1, group="p@1"), agent("b", seed=1, group="p@1")]
    assert presets_of(same) == {}
    assert list(presets_of([*same[:1], agent("c", seed=2, group="p@1")])) == ["p@1, 10 Hz"]
    assert presets_of([same[0], agent("d", seed=2, group="q@2")]) == {}


def test_contacts_have_a_poisson_interval_only_where_they_may() -> None:
    few = [3.0, 5.0, 4.0, 8.0, 4.0, 2.0, 3.0, 5.0]  # dispersion 0.79
    regular = [4.0] * 8
    results = results_of(
        {BLIND: {"a/1": [50.0] * 8, "a/2": [50.0] * 8}, "mine": {"a/1": few, "a/2": regular}},
        [agent("mine")],
    )
    one, other = card_of(results).cells["mine"]
    assert one.contacts_per_100m is not None
    assert (one.contacts_per_100m.low, one.contacts_per_100m.high) == (
        pytest.approx(23.546 / 8, abs=1e-2),  # Garwood's interval of 34
        pytest.approx(47.512 / 8, abs=1e-2),
    )
    assert other.contacts_per_100m is not None
    assert other.contacts_per_100m.low == other.contacts_per_100m.high == pytest.approx(4.0)


def test_nothing_that_happened_has_an_upper_bound() -> None:
    results = results_of({BLIND: {"a/1": [9.0] * 8}, "mine": {"a/1": [0.0] * 8}}, [agent("mine")])
    (cell,) = card_of(results).cells["mine"]
    assert cell.contacts_per_100m is not None
    assert cell.contacts_per_100m.low == 0.0
    assert cell.contacts_per_100m.high == pytest.approx(100.0 * 3.689 / 800.0, rel=1e-3)


def test_middle_means_are_interquartile_means_of_columns() -> None:
    values = np.random.default_rng(5).normal(size=(11, 3))
    expected = [interquartile_mean(values[:, column]) for column in range(3)]
    assert middle_means(values) == pytest.approx(expected)


def test_results_are_read_back_from_json_as_they_were() -> None:
    results = preset(3)
    assert Results.from_json(json.loads(json.dumps(results.to_json()))) == results
