"""One comparison in place of the geometry: it never says free where something is touched."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from reflexarc_runtime.beams import Beams, Fan, fan_of
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.guard import AGE_STEPS, Answer, Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.reach import MOST_BEAMS, MOST_FANS, USES, Reaches, reaches_m, sweeps_nothing
from support.slow_sweep import first_touch_s

VALID_S = 0.1
CART = Footprint(ahead_m=0.3, behind_m=0.2, half_width_m=0.15)
footprints = st.sampled_from([Footprint(), Footprint(0.2), CART, Footprint(ahead_m=0.5)])
speeds = st.one_of(
    st.just(0.0),
    st.floats(-1.5, 1.5).filter(lambda v: abs(v) > 1e-12),
    st.sampled_from([1e-9, -1e-6, 1e-5, -2e-5, 3.0, -8.0]),
)
twists = st.tuples(speeds, speeds, speeds)
ordinary = st.integers(-15, 15).map(lambda tenths: tenths / 10.0)
ordinary_twists = st.tuples(ordinary, ordinary, ordinary)
ages = st.one_of(st.floats(0.0, VALID_S), st.sampled_from([0.0, 0.0125, 0.05, 0.0999999, VALID_S]))
known = st.builds(
    GuardSettings,
    margin_m=st.sampled_from([0.001, 0.05, 0.2]),
    footprint=footprints,
    delay_s=st.sampled_from([0.0, 0.2]),
    deceleration_mps2=st.sampled_from([None, 0.5, 2.0]),
    evade_s=st.sampled_from([0.0, 0.3]),
)
fans = st.sampled_from(
    [(1.4, -0.35, 9), (-math.pi / 2, math.pi / 30, 31), (-math.pi, math.pi / 18, 36), (0.1, 0.2, 2)]
)


def learned(guard: Guard, fan: Fan) -> Guard:
    guard.prepare(fan)
    return guard


def one_action(mine: GuardSettings, twist) -> Guard:
    return Guard(mine, (Action("only", *twist),), VALID_S)


@settings(
    max_examples=400,
    deadline=None,
    suppress_health_check=[HealthCheck.filter_too_much],  # many motions have no bound
)
@given(st.data(), known, twists, fans, ages)
def test_what_is_surely_free_is_free_by_the_geometry(data, mine, twist, angles, age_s):
    fan, guard = fan_of(*angles), one_action(mine, twist)
    bound_m = guard._work_out(fan, 0)[min(int(age_s * AGE_STEPS / VALID_S), AGE_STEPS - 1)]
    assume(np.isfinite(bound_m).all())
    steps = age_s * AGE_STEPS / VALID_S
    assume(abs(steps - round(steps)) > 1e-9)  # at an edge rounding may take the stricter bound
    above = st.sampled_from([0.0, 0.0, 1e-9, 0.01, 0.3, math.inf])
    seen = bound_m + np.array(
        data.draw(st.lists(above, min_size=len(bound_m), max_size=len(bound_m)))
    )
    beams, learnt = Beams(fan, seen), learned(one_action(mine, twist), fan)
    if age_s < VALID_S:
        assert learnt._is_surely_free(0, beams, age_s)
    assert guard.share(twist, beams, age_s + mine.evade_s) == 1.0


@settings(max_examples=150, deadline=None)
@given(footprints, ordinary_twists, st.floats(0.05, 1.5), st.sampled_from([0.001, 0.05]))
def test_behind_the_bound_a_slow_sweep_touches_nothing_and_well_before_it_something(
    footprint, twist, way_s, margin_m
):
    assume(not sweeps_nothing(footprint, twist))
    fan = fan_of(-math.pi, math.pi / 6, 12)
    bound_m = reaches_m(fan, footprint, margin_m, twist, [way_s])[0]

    def touched(shift_m: float, wider_m: float) -> list[float]:
        spots = [
            ((r + shift_m) * c, (r + shift_m) * s)
            for r, c, s in zip(bound_m, fan.cos, fan.sin, strict=True)
        ]
        return [first_touch_s([spot], footprint, wider_m, twist, way_s, 2e-3) for spot in spots]

    assert min(touched(1e-6, margin_m)) > way_s
    farthest = int(np.argmax(bound_m))
    if bound_m[farthest] > footprint.reach_m + 1.5 * margin_m + 0.12:  # it begins outside
        assert touched(-0.05, margin_m + 0.03)[farthest] <= way_s + 2e-3


@settings(max_examples=150, deadline=None)
@given(st.data(), known, st.lists(twists, min_size=1, max_size=4), fans, ages)
def test_an_answer_is_the_same_with_and_without_what_is_known(data, mine, motions, angles, age_s):
    actions = tuple(Action(str(i), *twist) for i, twist in enumerate(motions))
    fan, plain = fan_of(*angles), Guard(mine, actions, VALID_S)
    ranges = st.one_of(st.floats(0.0, 4.0), st.just(math.inf), st.sampled_from([math.nan, -1.0]))
    size = len(fan.cos)
    beams = Beams(fan, np.array(data.draw(st.lists(ranges, min_size=size, max_size=size))))
    wanted = data.draw(st.integers(0, len(actions) - 1))
    values = data.draw(st.lists(st.floats(0, 1), min_size=len(actions), max_size=len(actions)))
    expected = plain.answer(wanted, values, beams, age_s)
    assert (
        learned(Guard(mine, actions, VALID_S), fan).answer(wanted, values, beams, age_s) == expected
    )


def test_no_bound_says_free_of_what_was_not_measured_or_lies_out_of_sight():
    mine, fan = GuardSettings(footprint=Footprint(0.2)), fan_of(-math.pi / 2, math.pi / 30, 31)
    ahead = learned(one_action(mine, (1.0, 0.0, 0.0)), fan)
    seen = np.full(31, math.inf)
    assert ahead._is_surely_free(0, Beams(fan, seen), 0.0)
    for unknown in (math.nan, 0.0, -1.0, -math.inf):
        seen[15] = unknown
        assert not ahead._is_surely_free(0, Beams(fan, seen), 0.0)
    for twist in ((-1.0, 0.0, 0.0), (0.0, 1.0, 2.0), (1e200, 0.0, 1e200), (1e9, 0.0, 0.0)):
        guard = learned(one_action(mine, twist), fan)
        assert not guard._is_surely_free(0, Beams(fan, np.full(31, math.inf)), 0.0)


def test_an_older_range_needs_a_longer_way():
    mine, fan = GuardSettings(footprint=Footprint(0.2)), fan_of(-1.0, 0.1, 21)
    ahead = learned(one_action(mine, (1.0, 0.0, 0.0)), fan)
    seen = np.full(21, math.inf)
    seen[10] = 0.2 + 0.05 + (0.1 + 0.3 + 0.05) + 0.01  # radius, margin, validity, evasion, age
    assert ahead._is_surely_free(0, Beams(fan, seen), 0.03)
    assert not ahead._is_surely_free(0, Beams(fan, seen), 0.07)
    assert not ahead._is_surely_free(0, Beams(fan, np.full(21, math.inf)), VALID_S)


def counted() -> tuple[Reaches, list[Fan]]:
    done: list[Fan] = []

    def work_out(fan: Fan, action: int) -> np.ndarray:
        done.append(fan)
        return np.zeros((AGE_STEPS, len(fan.cos)))

    return Reaches(work_out), done


def test_a_bound_is_worked_out_once_a_fan_has_been_used_often():
    reaches, done = counted()
    fan = fan_of(0.0, 0.1, 5)
    assert [reaches.of(fan, 0) is None for _ in range(USES + 1)] == [True] * USES + [False]
    assert reaches.of(fan, 0) is reaches.of(fan, 0)
    assert reaches.of(fan, 1) is not None
    assert done == [fan, fan]


def test_a_sender_of_ever_new_angles_costs_no_bound_and_no_memory():
    reaches, done = counted()
    kept = fan_of(0.0, 0.1, 5)
    reaches.prepare(kept, 1)
    for number in range(1000):
        reaches.of(fan_of(0.001 * number, 0.1, 5), 0)
        assert reaches.of(kept, 0) is not None
    assert done == [kept]
    assert len(reaches._fans) == MOST_FANS
    wide = fan_of(0.0, 1e-4, MOST_BEAMS + 1)
    assert all(reaches.of(wide, 0) is None for _ in range(3 * USES))


@pytest.mark.parametrize("evade_s", [0.0, 0.3])
def test_the_wanted_action_comes_first_also_where_another_is_surely_free(evade_s):
    mine = replace(GuardSettings(footprint=Footprint(0.2)), evade_s=evade_s)
    actions = (Action("ahead", 1.0, 0.0), Action("left", 1.0, 1.0), Action("right", 1.0, -1.0))
    fan = fan_of(-math.pi / 2, math.pi / 180, 181)
    guard, seen = learned(Guard(mine, actions, VALID_S), fan), np.full(181, math.inf)
    assert guard.answer(0, (0.0, 0.2, 0.5), Beams(fan, seen), 0.0) == Answer(0, 1.0)
    seen[100] = 0.34
    assert guard.answer(0, (0.9, 0.2, 0.5), Beams(fan, seen), 0.0) == Answer(2, 1.0)
