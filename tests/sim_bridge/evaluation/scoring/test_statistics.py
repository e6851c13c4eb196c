"""Interquartile means and intervals, against hand calculations and a slow bootstrap."""

import math
import statistics as standard

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_sim_bridge.evaluation.scoring.statistics import (
    estimate,
    interquartile_mean,
    ratio_estimate,
)

FIGURES = st.lists(st.floats(0.0, 100.0), min_size=1, max_size=40)


@pytest.mark.parametrize(
    ("values", "mean"),
    [
        ([7.0], 7.0),
        ([1.0, 3.0], 2.0),
        ([1.0, 2.0, 300.0], 101.0),  # ⌊3/4⌋ = 0: nothing to leave away
        ([100.0, 2.0, 4.0, -50.0], 3.0),
        ([9.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 90.0], 5.5),  # 3 to 8, two left at each end
    ],
)
def test_interquartile_mean_is_the_mean_of_the_middle_half(
    values: list[float], mean: float
) -> None:
    assert interquartile_mean(values) == pytest.approx(mean, rel=1e-15)


@given(FIGURES)
def test_interquartile_mean_is_the_trimmed_mean_as_one_writes_it_down(values: list[float]) -> None:
    cut = math.floor(len(values) / 4)
    middle = sorted(values)[cut : len(values) - cut]
    assert interquartile_mean(values) == pytest.approx(standard.fmean(middle), abs=1e-12)


@settings(deadline=None, max_examples=30)
@given(FIGURES)
def test_interval_holds_the_mean_of_few_values_and_lies_within_them(values: list[float]) -> None:
    value, low, high = estimate(values)
    assert min(values) - 1e-9 <= low <= high <= max(values) + 1e-9
    assert low - 1e-9 <= value <= high + 1e-9 or len(values) > 3


def test_interval_is_that_of_a_slow_bootstrap() -> None:
    generator = np.random.default_rng(4)
    values = generator.normal(10.0, 2.0, 20)
    draws = [
        interquartile_mean([values[i] for i in generator.integers(0, 20, 20)]) for _ in range(4000)
    ]
    _, low, high = estimate(values)
    assert low == pytest.approx(np.percentile(draws, 2.5), abs=0.1)
    assert high == pytest.approx(np.percentile(draws, 97.5), abs=0.1)


def test_interval_covers_the_truth_about_as_often_as_it_says() -> None:
    generator = np.random.default_rng(5)
    samples = generator.normal(0.0, 1.0, (100, 30))
    covered = [low <= 0.0 <= high for _, low, high in map(estimate, samples)]
    assert 0.85 < np.mean(covered) < 1.0


def test_the_same_values_give_the_same_interval() -> None:
    assert estimate([1.0, 5.0, 2.0, 8.0]) == estimate([1.0, 5.0, 2.0, 8.0])
    assert estimate([3.0, 3.0, 3.0]) == (3.0, 3.0, 3.0)


def test_ratio_is_of_the_means_and_its_interval_of_both_groups() -> None:
    generator = np.random.default_rng(6)
    ours, theirs = generator.normal(3.0, 0.3, 12), generator.normal(6.0, 0.6, 12)
    value, low, high = ratio_estimate(ours, theirs)
    assert value == pytest.approx(interquartile_mean(ours) / interquartile_mean(theirs))
    assert low < value < high
    fixed = ratio_estimate(ours, [6.0] * 12)
    assert high - low > fixed.high - fixed.low
    assert fixed.high == pytest.approx(estimate(ours).high / 6.0, rel=0.02)
