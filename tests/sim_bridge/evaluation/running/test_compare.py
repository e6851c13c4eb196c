"""Comparisons of two policies, really driven, in small."""

from dataclasses import replace

import pytest

from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.evaluation.driving.paired_drive import LOOKS
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.running.compare import Comparison, Terms, compare
from reflexarc_sim_bridge.evaluation.scoring.regression import Claim, overall

SPARSE = SuiteCell("sparse", "reference-1", clutter=0.05)
DISCS = SuiteCell("discs", "discs")
NEVER_COUNTED = SuiteCell("noisy", "noisy", counts=False)
SMALL = Suite(
    "small",
    1,
    families=(
        SuiteFamily("boxes", cells=(SPARSE, NEVER_COUNTED)),
        SuiteFamily("discs", cells=(DISCS,)),
        SuiteFamily("beside", cells=(NEVER_COUNTED,)),
    ),
)
BLIND = Entrant("blind", "blind")
AWAY = Entrant("2a", "reflexarc_baselines.anchors.braitenberg:Braitenberg2a")
TERMS = Terms(worlds=24)


def test_a_policy_against_itself_keeps_without_any_doubt() -> None:
    verdicts = compare(AWAY, AWAY, SMALL, Setting.FIELD, TERMS)
    assert [v.family for v in verdicts] == ["boxes", "discs"]
    assert {(v.claim, v.loss, v.low, v.high, v.looks) for v in verdicts} == {
        (Claim.KEEPS, 0.0, 0.0, 0.0, 1)
    }


def test_a_policy_that_does_not_look_loses_and_the_other_way_round_keeps() -> None:
    worse = compare(BLIND, AWAY, SMALL, Setting.FIELD, TERMS, jobs=2)
    assert overall(worse) is Claim.LOSES
    assert min(v.loss for v in worse) > 1.0
    better = compare(AWAY, BLIND, SMALL, Setting.FIELD, TERMS, jobs=1)
    assert overall(better) is Claim.KEEPS


def test_the_number_of_processes_changes_nothing() -> None:
    one, two = (compare(BLIND, AWAY, SMALL, Setting.FIELD, TERMS, jobs=n) for n in (1, 2))
    assert one == two


def test_a_family_with_more_driving_is_looked_at_again_until_it_is_decided() -> None:
    near = replace(AWAY, name="at 5 Hz", rate_hz=5.0)
    terms = Terms(margin=0.01, worlds=8)
    looks = Comparison(near, AWAY, (SPARSE,), Setting.ROBOT, terms, 12).looks()
    assert len(looks) == LOOKS
    assert looks[-1].error < looks[0].error


def test_bodies_of_two_kinds_cannot_be_compared() -> None:
    turner = Entrant("rover", f"{__file__}:Turner")
    with pytest.raises(ReflexarcError, match="rover turns and blind does not"):
        compare(turner, BLIND, SMALL, Setting.FIELD, TERMS)


def test_bodies_that_turn_are_compared_by_how_far_they_come() -> None:
    straight = Entrant("straight", f"{__file__}:Turner")
    circling = Entrant("circling", f"{__file__}:Circler")
    [verdict] = compare(circling, straight, SMALL.only(("discs",)), Setting.FIELD, Terms(worlds=6))
    assert verdict.claim is Claim.LOSES
    assert verdict.loss > 1.0


class Turner:
    """A body that turns, and never does."""

    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.contract.motion import Action

    contract = PolicyContract(
        actions=(Action("stay", 1.0, 0.0), Action("left", 1.0, 0.0, 2.0)), rate_hz=10.0
    )
    always = 0

    def decide(self, retinas):  # type: ignore[no-untyped-def]  # as a stranger writes it
        import numpy as np

        n = len(retinas)
        return np.zeros((n, 2), np.float32), np.full(n, self.always, np.int64)


class Circler(Turner):
    """A body that always turns."""

    always = 1
