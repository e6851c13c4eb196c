"""Exact intervals of counts, against tables and against the plain sum of the distribution."""

import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.scoring.poisson_interval import (
    dispersion,
    may_be_poisson,
    poisson_interval,
)

GARWOOD = {
    0: (0.0, 3.6889),
    1: (0.0253, 5.5716),
    5: (1.6235, 11.6683),
    10: (4.7954, 18.3904),
    100: (81.3640, 121.6270),
}
"""Of F. Garwood, Biometrika 28, 1936, as epidemiologists tabulate them."""


@pytest.mark.parametrize("count", sorted(GARWOOD))
def test_the_interval_is_the_one_of_the_tables(count: int) -> None:
    assert poisson_interval(count) == pytest.approx(GARWOOD[count], abs=1e-3)


@pytest.mark.parametrize("count", [1, 3, 17, 60])
def test_each_end_leaves_a_fortieth_outside(count: int) -> None:
    low, high = poisson_interval(count)

    def at_most(k: int, mean: float) -> float:
        return math.fsum(math.exp(-mean) * mean**j / math.factorial(j) for j in range(k + 1))

    assert at_most(count, high) == pytest.approx(0.025, rel=1e-9)
    assert 1.0 - at_most(count - 1, low) == pytest.approx(0.025, rel=1e-9)


def test_a_large_count_is_nearly_normal() -> None:
    low, high = poisson_interval(40_000)
    assert low == pytest.approx(40_000 - 1.96 * 200, abs=4.0)
    assert high == pytest.approx(40_000 + 1.96 * 200, abs=4.0)


def test_nothing_in_a_distance_has_an_upper_bound_of_3_7() -> None:
    assert poisson_interval(0) == (0.0, pytest.approx(-math.log(0.025)))
    assert may_be_poisson(np.zeros(8))
    assert dispersion(np.zeros(8)) is None


def test_dispersion_is_variance_over_mean() -> None:
    assert dispersion(np.array([1.0, 3.0, 5.0])) == pytest.approx(4.0 / 3.0)
    assert dispersion(np.array([4.0])) is None


def test_contacts_that_come_in_groups_have_no_poisson_interval() -> None:
    poisson = np.random.default_rng(1).poisson(20.0, 4000).astype(float)
    assert may_be_poisson(poisson)
    assert not may_be_poisson(2.0 * poisson)
    assert not may_be_poisson(np.full(8, 5.0))  # too regular
    assert not may_be_poisson(np.array([3.0]))  # one world tells nothing of it
