"""Bounds for bodies that turn: nobody passes the upper one, and the lower one was driven."""

import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.limits.turners import least_reached_m, most_reached_m
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy

ACTIONS = (
    Action("ahead", 1.0, 0.0),
    Action("left", 1.0, 0.0, 1.5),
    Action("right", 1.0, 0.0, -1.5),
)
TURNER = Contender("turner", BlindPolicy(), PolicyContract(actions=ACTIONS))
CELL = SuiteCell("0.10", "reference-1", clutter=0.1)
FAMILIES = (SuiteFamily("f", cells=(CELL,)),)
SUITE = Suite("t", 1, worlds=4, lanes=2, turner_s=12.0, families=FAMILIES)


def test_straight_on_for_the_whole_time_is_the_farthest():
    assert most_reached_m(TURNER.contract, 60.0) == 60.0
    fast = PolicyContract(actions=(*ACTIONS, Action("rush", 3.0, 4.0)))
    assert most_reached_m(fast, 2.0) == 10.0


def test_without_obstacles_both_bounds_are_one():
    empty = replace(CELL, clutter=1e-9)
    reached_m = least_reached_m(TURNER, empty, SUITE, Setting.FIELD)
    np.testing.assert_allclose(reached_m, most_reached_m(TURNER.contract, 12.0))


def test_a_search_that_knows_all_comes_farther_than_blind_and_no_farther_than_the_upper_bound():
    reached_m = least_reached_m(TURNER, CELL, SUITE, Setting.FIELD)
    track = drive(TURNER, CELL, SUITE, Setting.FIELD)
    first = np.where(track.met.any(axis=0), track.met.argmax(axis=0), track.steps)
    blind_m = first * track.circumstances.dt_s  # straight on, at 1 m/s, from the same places
    assert reached_m.shape == (8,)
    assert (reached_m <= most_reached_m(TURNER.contract, 12.0) + 1e-9).all()
    # It counts whole stretches of 0.2 s only.
    assert (reached_m >= blind_m - 0.2 - 1e-9).all()
    assert reached_m.mean() > blind_m.mean() + 3.0


def test_who_can_only_turn_left_never_leaves_its_circle():
    circler = PolicyContract(actions=(ACTIONS[1], replace(ACTIONS[1], name="also")))
    contender = Contender("circler", BlindPolicy(2), circler)
    reached_m = least_reached_m(contender, replace(CELL, clutter=1e-9), SUITE, Setting.FIELD)
    radius_m = 1.0 / 1.5
    assert reached_m.max() == pytest.approx(2.0 * radius_m, rel=0.02)
    assert reached_m.max() <= 2.0 * radius_m * math.sqrt(1.0 + 1e-9)


def test_a_body_that_does_not_turn_is_refused():
    with pytest.raises(UsageError, match="expected a body that turns"):
        least_reached_m(contender_of(BLIND), CELL, SUITE, Setting.FIELD)
