"""The clutter axis: its limits, and the clutter at which no way leads through."""

import math

import pytest

from reflexarc_sim_bridge.evaluation.limits.clutter_axis import (
    clutter_curve,
    critical_clutter,
    share_passed,
)
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily

CELL = SuiteCell("any", "reference-1")
FAMILIES = (SuiteFamily("f", cells=(CELL,)),)
SUITE = Suite("t", 1, worlds=4, lanes=8, families=FAMILIES)


@pytest.mark.long
def test_blind_meets_what_is_in_its_way_and_an_oracle_only_what_it_must():
    sideways = 0.5
    sparse, dense = clutter_curve(SUITE, sideways, (0.1, 0.5))
    for point in (sparse, dense):
        # Of rectangles, R is half their mean width of 0.9 m: 2ρR = 2 · clutter · (w/v) / R.
        expected = 100.0 * 2.0 * point.clutter * sideways / 0.45
        # 4 · 8 · 15 contacts of blind agents; a step of 0.1 m loses up to 2 %.
        assert point.blind_per_100m == pytest.approx(expected, rel=3.5 / math.sqrt(4 * 8 * 15))
        assert point.oracle_per_100m < point.blind_per_100m
    # Not 0: some places, where one may be put several times in a row, are dead ends.
    assert sparse.oracle_per_100m < 1e-6
    assert dense.oracle_per_100m > 1.0


@pytest.mark.long
def test_ways_close_where_theory_says_that_they_must():
    assert critical_clutter((0.2, 0.25), 1.0, 40.0, 80.0, 10.0, 8) == (0.2, 0.25)


def test_longer_stretches_are_not_easier():
    short, long = (share_passed(0.24, 1.0, 20.0, length_m, 10.0, 8) for length_m in (10.0, 60.0))
    assert long < short
