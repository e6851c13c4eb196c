"""The range-limited planner: what it plans by hand, what it must not know, where it stands."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.limits.horizon import plan
from reflexarc_sim_bridge.evaluation.limits.oracle import oracle_sums
from reflexarc_sim_bridge.evaluation.limits.planner import Planner
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.native.cache import prepare

STEPS, ROWS, ROW = 5, 13, 6
SHIFTS = np.array([0, 1, -1])
NAME = "reflexarc_sim_bridge.evaluation.limits.planner:Planner"
CELL = SuiteCell("0.10", "reference-1", clutter=0.1)
FAMILIES = (SuiteFamily("f", cells=(CELL,)),)
SUITE = Suite("t", 1, worlds=4, lanes=2, free_paths=6.0, families=FAMILIES)


def planned(found, range_m=math.inf, half_view_rad=math.pi, count=STEPS):
    prepare()
    motions = np.zeros(count, np.int64)
    scratch, choices = np.zeros((2, 2, ROWS)), np.zeros((count, ROWS), np.int64)
    view = 1.0, 0.5, range_m, half_view_rad
    plan(found, SHIFTS, ROW, *view, *scratch, choices, motions)
    return motions


def last_step(found, motions):
    row = ROW
    for m, motion in enumerate(motions):
        if found[m, row] >> int(motion) & 1:
            return m
        row += SHIFTS[motion]
    return STEPS


@pytest.mark.parametrize("seed", range(8))
def test_a_contact_is_put_off_as_long_as_any_sequence_of_motions_can(seed):
    rng = np.random.default_rng(seed)
    found = (rng.random((STEPS, ROWS, 3)) < 0.6) @ np.array([1, 2, 4])
    found = found.astype(np.uint8)
    best = max(last_step(found, each) for each in itertools.product(range(3), repeat=STEPS))
    assert last_step(found, planned(found)) == best


def test_among_ways_that_are_free_the_roomier_one_is_taken():
    found = np.zeros((STEPS, ROWS), np.uint8)
    found[0, ROW] = 1  # straight on is blocked; to the left all is free, to the right one row
    found[2:, : ROW - 1] = 7
    assert planned(found, count=1)[0] == 1
    assert planned(found[:, ::-1].copy(), count=1)[0] == 2


@pytest.mark.parametrize(("range_m", "half_view_rad"), [(2.5, math.pi), (math.inf, 0.05)])
def test_what_is_out_of_view_changes_nothing(range_m, half_view_rad):
    found = np.zeros((STEPS, ROWS), np.uint8)
    found[3:, :ROW] = 7
    found[3:, ROW + 1 :] = 7
    found[3:, ROW] = 7 if math.isfinite(range_m) else 0
    seen = planned(found, range_m, half_view_rad, 1)
    assert seen[0] == planned(np.zeros_like(found), range_m, half_view_rad, 1)[0]


def test_it_is_a_contender_by_its_name_and_stands_between_blind_and_oracle():
    planner = contender_of(NAME)
    own = sums_of(drive(planner, CELL, SUITE, Setting.FIELD))
    blind = sums_of(drive(contender_of(BLIND), CELL, SUITE, Setting.FIELD))
    oracle = oracle_sums(planner, CELL, SUITE, Setting.FIELD)
    assert oracle["contacts"].sum() <= own["contacts"].sum() + 3.0
    assert own["contacts"].sum() < 0.25 * blind["contacts"].sum()


def test_who_sees_farther_meets_less():
    met = []
    for range_m in (0.3, 5.0):
        retina = RetinaSpec(range_m=range_m)
        contract = PolicyContract(retina=retina, actions=sideways_actions(1.0, 0.5))
        contender = Contender("planner", Planner(contract), contract)
        met.append(int(drive(contender, CELL, SUITE, Setting.FIELD).met.sum()))
    assert met[1] < 0.6 * met[0]


def test_a_body_that_does_not_obey_exactly_is_planned_for_where_it_is():
    slippery = replace(CELL, world="slippery", clutter=None)
    track = drive(contender_of(NAME), slippery, replace(SUITE, lanes=1), Setting.FIELD)
    assert track.progress_m.sum() > 0
    assert track.met.mean() < 0.01


def test_a_guard_has_no_eye_to_see_by_for_who_knows_everything():
    with pytest.raises(UsageError, match="expected no guard"):
        drive(contender_of(NAME, is_guarded=True), CELL, SUITE, Setting.FIELD)
