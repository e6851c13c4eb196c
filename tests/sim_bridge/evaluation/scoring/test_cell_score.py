"""The score of a cell, by hand."""

import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.scoring.cell_score import between, cell_score, rate_per_m


def sums(contacts, progress_m=(100.0, 300.0), time_s=(100.0, 300.0)):
    return {
        "contacts": np.array(contacts, np.float64),
        "progress_m": np.array(progress_m),
        "time_s": np.array(time_s),
    }


BLIND, ORACLE = sums([30.0, 130.0]), sums([0.0, 4.0])


def test_blind_scores_nothing_and_the_oracle_everything():
    assert cell_score(BLIND, BLIND, ORACLE) == 0.0
    assert cell_score(ORACLE, BLIND, ORACLE) == 1.0


@pytest.mark.parametrize(
    ("contacts", "score"),
    [([20.0, 62.0], 0.5), ([0.0, 43.0], 0.75), ([100.0, 138.0], -0.5), ([900.0, 0.0], -1.0)],
)
def test_contacts_score_in_proportion(contacts, score):
    # Of 400 m: blind 160, oracle 4, so a contact less is 1/156.
    assert cell_score(sums(contacts), BLIND, ORACLE) == pytest.approx(score)


def test_luck_beyond_the_oracle_scores_no_more_than_it():
    assert cell_score(sums([0.0, 1.0]), BLIND, ORACLE) == 1.0


def test_where_blind_is_as_good_as_it_gets_there_is_no_score():
    assert math.isnan(cell_score(sums([5.0, 5.0]), sums([10.0, 0.0]), sums([9.1, 0.0])))
    assert math.isnan(cell_score(sums([0.0, 0.0]), sums([0.0, 0.0]), sums([0.0, 0.0])))
    assert not math.isnan(cell_score(sums([5.0, 5.0]), sums([10.0, 0.0]), sums([8.9, 0.0])))


def test_who_stands_has_no_contacts_and_the_lowest_score():
    stands = sums([0.0, 0.0], progress_m=(0.0, 0.0))
    assert rate_per_m(stands) == math.inf
    assert cell_score(stands, BLIND, ORACLE) == -1.0
    creeps = sums([0.0, 0.0], progress_m=(9.0, 30.0))
    assert cell_score(creeps, BLIND, ORACLE) == -1.0
    assert cell_score(sums([0.0, 0.0], progress_m=(20.0, 60.0)), BLIND, ORACLE) == 1.0


def test_farther_is_better_where_the_limit_is_a_distance():
    scores = between([0.8, 3.0, 21.5, 60.0, 61.0], 3.0, 60.0)
    np.testing.assert_allclose(scores, [-2.2 / 57.0, 0.0, 18.5 / 57.0, 1.0, 1.0])


def test_scores_of_many_worlds_are_taken_at_once():
    scores = between([[1.0, 2.0], [3.0, 4.0]], [4.0, 2.0], [0.0, 2.0])
    np.testing.assert_allclose(scores, [[0.75, np.nan], [0.25, np.nan]])
