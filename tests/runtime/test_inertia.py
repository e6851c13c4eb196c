"""A body that changes its motion in time: the path it takes, by hand and against small steps."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.beams import Beams, fan_of
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.guard import STAND, Answer, Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.inertia import Moving, Order, followed, path, touches

speeds = st.integers(-12, 12).map(lambda v: v / 8.0)
planar = st.tuples(speeds, speeds)


def slow_path(now, order, braking, step_s=1e-4):
    """Places of the body, step by step, in the plainest way."""
    (vx, vy, turning), x, y, heading, places = now, 0.0, 0.0, 0.0, []
    ends_s, time_s = order.felt_s + order.held_s, 0.0
    while time_s < ends_s or vx or vy:
        wanted = order.twist if order.felt_s <= time_s < ends_s else None
        if wanted is not None:
            turning = wanted[2]
        if time_s >= ends_s:
            wanted, turning = (0.0, 0.0, 0.0), 0.0
        if wanted is not None:
            vx += min(max(wanted[0] - vx, -braking * step_s), braking * step_s)
            vy += min(max(wanted[1] - vy, -braking * step_s), braking * step_s)
        heading += turning * step_s
        x += step_s * (vx * math.cos(heading) - vy * math.sin(heading))
        y += step_s * (vx * math.sin(heading) + vy * math.cos(heading))
        places.append((x, y))
        time_s += step_s
    return np.array(places)


@settings(max_examples=40, deadline=None)
@given(planar, planar, st.sampled_from([0.0, 0.1]), st.sampled_from([0.1, 0.4]))
def test_the_path_is_what_small_steps_make(now, wanted, felt_s, held_s):
    order = Order((*wanted, 0.0), felt_s, held_s)
    quick = np.vstack([np.zeros(2), path((*now, 0.0), order, 1.0)[:, :2]])
    for place in slow_path((*now, 0.0), order, 1.0)[::200]:
        ends = itertools.pairwise(quick)
        assert min(distance_m(place, *pair) for pair in ends) < 0.02


def distance_m(point, begin, end) -> float:
    """From a point to a piece of a line."""
    way = end - begin
    share = np.clip((point - begin) @ way / max(way @ way, 1e-18), 0.0, 1.0)
    return float(np.hypot(*(point - begin - share * way)))


def test_after_a_change_of_side_it_goes_on_to_the_old_one_by_hand():
    places = path((1.0, 1.0, 0.0), Order((1.0, -1.0, 0.0), 0.0, 2.0), 1.0)
    assert places[:, 1].max() == pytest.approx(0.5, abs=2e-3)  # 1² / 2
    assert places[-1, 1] == pytest.approx(-0.5, abs=2e-2)  # back after 2 s, then 1² / 2 to brake
    assert places[-1, 0] == pytest.approx(2.5, abs=2e-2)


def test_what_a_body_does_follows_what_it_was_told_while_that_is_valid():
    moving = Moving((1.0, 0.5, 0.3), (1.0, -1.0, 0.0), 0)
    assert moving.later(50_000_000, 100_000_000, 2.0) == pytest.approx((1.0, 0.4, 0.0))
    assert moving.later(200_000_000, 100_000_000, 2.0) == pytest.approx((0.8, 0.1, 0.0))
    assert followed((0.0, 0.0, 0.0), (1.0, -1.0, 0.5), 5.0) == (1.0, -1.0, 0.5)


SIDES = (Action("ahead", 1.0, 0.0), Action("left", 1.0, 1.0), Action("right", 1.0, -1.0))
BODY = GuardSettings(footprint=Footprint(0.2), deceleration_mps2=1.0, evade_s=0.0)


def seen(*points: tuple[float, float]) -> Beams:
    """A fine scan over 180 degrees that meets these points."""
    ranges_m = np.full(361, math.inf)
    for x, y in points:
        ranges_m[180 + round(math.degrees(math.atan2(y, x)) * 2)] = math.hypot(x, y)
    return Beams(fan_of(-math.pi / 2, math.pi / 360, 361), ranges_m)


def test_a_change_of_side_is_free_only_if_the_curve_to_it_is():
    guard, post = Guard(BODY, SIDES, 0.1), seen((0.5, 0.42))  # a way to the left of straight ahead
    to_the_left = (1.0, 1.0, 0.0)
    assert guard.share((1.0, -1.0, 0.0), post, 0.0) == 1.0
    assert guard.share((1.0, -1.0, 0.0), post, 0.0, (1.0, -1.0, 0.0)) == 1.0
    assert guard.share((1.0, -1.0, 0.0), post, 0.0, to_the_left) < 1.0
    assert guard.answer(2, (0.0, 0.0, 1.0), post, 0.0) == Answer(2, 1.0)
    assert guard.answer(2, (0.0, 0.0, 1.0), post, 0.0, to_the_left) != Answer(2, 1.0)


def test_a_body_that_obeys_at_once_or_a_log_of_before_does_not_ask():
    post, to_the_left = seen((0.5, 0.42)), (1.0, 1.0, 0.0)
    for mine in (replace(BODY, inertia=False), replace(BODY, deceleration_mps2=None)):
        guard = Guard(mine, SIDES, 0.1)
        assert guard.share((1.0, -1.0, 0.0), post, 0.0, to_the_left) == 1.0
    older = BODY.to_json().replace('"inertia": true, ', "")
    assert GuardSettings.from_json(older) == replace(BODY, inertia=False)


def test_whoever_is_already_too_near_may_leave_and_not_drift_nearer():
    near, places = (np.array([0.22]), np.array([0.0])), np.array([[-0.1, 0.0, 0.0]])
    assert not touches(*near, Footprint(0.2), 0.05, places)
    assert touches(*near, Footprint(0.2), 0.05, -places)
    guard = Guard(BODY, (*SIDES, Action("back", -1.0, 0.0)), 0.1)
    circle = Beams(fan_of(-math.pi, math.pi / 180, 360), np.full(360, math.inf))
    circle.ranges_m[180] = 0.22
    assert guard.answer(3, (0.0,) * 4, circle, 0.0, (-1.0, 0.0, 0.0)) == Answer(3, 1.0)
    assert guard.answer(3, (0.0,) * 4, circle, 0.0, (1.0, 0.0, 0.0)) == STAND
