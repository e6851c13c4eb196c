"""The gate of policies: as often wrong, and as often right, as it says. On drawn contacts."""

import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.driving.paired_drive import LOOKS
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.scoring.regression import (
    SPENT,
    Claim,
    Look,
    holm,
    is_decided,
    is_last,
    judge,
    look_at,
    overall,
    p_over_looks,
    shares,
)

FAMILIES = 12
WORLDS = 400
MEANS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Contacts of each world before each look: each look has twice as much behind it."""


def looks_at(generator: np.random.Generator, ratio: float, margin: float = 0.1) -> list[Look]:
    """Looks at two policies of independent Poisson contacts, the new one `ratio` as often."""
    new, old, looks, before = np.zeros(WORLDS), np.zeros(WORLDS), list[Look](), 0.0
    for mean in MEANS:
        new += generator.poisson(ratio * (mean - before), WORLDS)
        old += generator.poisson(mean - before, WORLDS)
        before = mean
        looks.append(look_at(new, old))
        if is_decided(looks, margin, 0.05, FAMILIES):
            break
    return looks


def verdict(generator: np.random.Generator, ratios: list[float]) -> Claim:
    looks = {str(k): looks_at(generator, ratio) for k, ratio in enumerate(ratios)}
    return overall(judge(looks, 0.1, 0.05))


def test_the_error_is_that_of_two_independent_counts() -> None:
    """Var(ln(N/O)) = 1/N + 1/O for independent Poisson counts."""
    generator = np.random.default_rng(1)
    new, old = (
        generator.poisson(3.0, 4000).astype(float),
        generator.poisson(5.0, 4000).astype(float),
    )
    look = look_at(new, old)
    assert look.error == pytest.approx(math.sqrt(1 / new.sum() + 1 / old.sum()), rel=0.05)
    assert look.log_ratio == pytest.approx(math.log(new.sum() / old.sum()), abs=1e-4)


def test_the_same_contacts_in_the_same_worlds_leave_no_doubt() -> None:
    same: Floats = np.random.default_rng(2).poisson(2.0, 100).astype(float)
    look = look_at(same, same.copy())
    assert (look.log_ratio, look.error) == (0.0, 0.0)
    assert look.p_keeps(0.1) == 0.0
    assert look.p_loses(0.1) == 1.0


def test_no_contacts_at_all_are_equal_and_a_few_prove_little() -> None:
    none, one = np.zeros(50), np.eye(1, 50)[0]
    assert look_at(none, none) == Look(0.0, 0.0)
    assert look_at(one, none).error > 1.0
    assert look_at(one, none).p_loses(0.1) > 0.1


def test_holm_by_hand() -> None:
    """p 0.01, 0.02, 0.03, of three: 3 · 0.01, 2 · 0.02, and no less than the one before."""
    adjusted = holm({"a": 0.02, "b": 0.01, "c": 0.03})
    assert adjusted == pytest.approx({"b": 0.03, "a": 0.04, "c": 0.04})


def test_the_looks_share_the_level() -> None:
    assert sum(SPENT) == pytest.approx(1.0)
    assert len(SPENT) == LOOKS
    assert p_over_looks([0.001], is_last=False) == pytest.approx(0.05)
    assert p_over_looks([1.0, 1.0, 1.0, 1.0, 0.04], is_last=True) == pytest.approx(0.05)
    assert p_over_looks([0.9], is_last=False) == 1.0


def test_the_last_look_has_all_of_the_level_that_is_left() -> None:
    for looks in range(1, LOOKS + 1):
        assert sum(shares(looks, is_last=True)) == pytest.approx(1.0)
        assert shares(looks, is_last=False) == SPENT[:looks]
    assert shares(LOOKS, is_last=True) == pytest.approx(SPENT)


def test_no_look_follows_where_half_as_much_again_as_is_borne_would_be_found() -> None:
    """At 0.98 of 5 % in twelve: 2.645 errors; found nine times in ten: 1.282 more."""
    enough = math.log(1.15 / 1.1) / (2.645 + 1.282)
    unsure = Look(0.0, 1.0)
    assert is_last([unsure, Look(0.05, 0.999 * enough)], 0.1, 0.05, FAMILIES)
    assert not is_last([unsure, Look(0.05, 1.001 * enough)], 0.1, 0.05, FAMILIES)
    assert is_last([unsure] * LOOKS, 0.1, 0.05, FAMILIES)


@pytest.mark.parametrize("mean", [0.5, 2.0, 6.0])
def test_to_end_when_the_error_is_small_enough_raises_no_alarms(mean: float) -> None:
    """A family that loses just what is borne, alone at 5 %: of 1500, and 3 sigma."""
    generator, alarms, ended = np.random.default_rng(7), 0, set[int]()
    for _ in range(1500):
        new, old, looks = 0.0, 0.0, list[Look]()
        while not looks or not is_decided(looks, 0.1, 0.05, 1):
            length = 2.0 ** max(0, len(looks) - 1) * WORLDS * mean
            new, old = new + generator.poisson(1.1 * length), old + generator.poisson(length)
            looks.append(Look(math.log(new / old), math.sqrt(1.0 / new + 1.0 / old)))
        [said] = judge({"a": looks}, 0.1, 0.05)
        alarms += said.claim is Claim.LOSES
        ended.add(len(looks))
    assert alarms <= 75 + 26
    assert len(ended) > 1


def test_equal_policies_raise_a_false_alarm_in_at_most_one_case_in_twenty() -> None:
    """Of 200 independent pairs, all of whose families are equal: 5 % would be 10."""
    generator = np.random.default_rng(3)
    claims = [verdict(generator, [1.0] * FAMILIES) for _ in range(200)]
    assert claims.count(Claim.LOSES) <= 10
    assert claims.count(Claim.KEEPS) >= 180


def test_at_the_margin_itself_an_alarm_in_any_family_is_as_rare_as_said() -> None:
    """The least favourable case: every family loses just what is borne. 5 % of 200, and 3 sigma."""
    generator = np.random.default_rng(4)
    claims = [verdict(generator, [1.1] * FAMILIES) for _ in range(200)]
    assert claims.count(Claim.LOSES) <= 10 + 9


def test_a_loss_in_one_family_of_twelve_is_found_and_named() -> None:
    generator, found = np.random.default_rng(5), 0
    for _ in range(50):
        looks = {str(k): looks_at(generator, 1.25 if k == 7 else 1.0) for k in range(FAMILIES)}
        verdicts = judge(looks, 0.1, 0.05)
        found += [v.family for v in verdicts if v.claim is Claim.LOSES] == ["7"]
    assert found >= 40


def test_the_smallest_loss_that_is_named_is_found_four_times_in_five() -> None:
    generator, error, unsure = np.random.default_rng(6), 0.02, [Look(0.0, 9.0)] * (LOOKS - 1)
    [named] = judge({"a": [Look(0.0, error)] * LOOKS}, 0.1, 0.05)
    drawn = generator.normal(math.log1p(named.smallest), error, 4000)
    found = [judge({"a": [*unsure, Look(d, error)]}, 0.1, 0.05)[0] for d in drawn]
    share = np.mean([each.claim is Claim.LOSES for each in found])
    assert share == pytest.approx(0.8, abs=0.02)
