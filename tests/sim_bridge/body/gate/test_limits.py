import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.body_limits import FOR_EVER_NS, BodyLimits
from reflexarc_runtime.errors import ContractError
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion, eased, slowed

SPEEDS = st.floats(-1e300, 1e300)
MOTIONS = st.builds(Motion, SPEEDS, SPEEDS, SPEEDS)
LIMIT = st.floats(0.0, 1e300) | st.just(math.inf)
NAMES = ("linear_mps", "lateral_mps", "angular_radps")


@given(MOTIONS, st.builds(BodyLimits, LIMIT, LIMIT, LIMIT))
def test_a_slowed_motion_is_within_the_limits_and_has_the_same_direction(
    wanted: Motion, limits: BodyLimits
):
    motion, was_too_fast = slowed(wanted, limits)
    fits = all(abs(getattr(wanted, name)) <= getattr(limits, name) for name in NAMES)
    assert was_too_fast is not fits
    assert motion == wanted or was_too_fast
    for name in NAMES:
        speed, asked = getattr(motion, name), getattr(wanted, name)
        assert abs(speed) <= min(getattr(limits, name), abs(asked))
        assert speed * asked >= 0.0


@given(st.floats(0.1, 100.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_all_speeds_are_slowed_by_the_same_share(linear: float, lateral: float, angular: float):
    motion, _ = slowed(Motion(linear, lateral, angular), BodyLimits(linear_mps=0.1))
    share = 0.1 / linear
    assert motion == Motion(
        pytest.approx(0.1), pytest.approx(lateral * share), pytest.approx(angular * share)
    )


@given(MOTIONS, MOTIONS, st.floats(1e-3, 1e3), st.floats(-1.0, 10.0))
def test_a_speed_grows_no_faster_than_the_acceleration_and_falls_at_once(
    before: Motion, wanted: Motion, acceleration: float, dt_s: float
):
    motion = eased(before, wanted, acceleration, dt_s)
    assert motion.angular_radps == wanted.angular_radps
    for name in NAMES[:2]:
        was, asked, now = (getattr(one, name) for one in (before, wanted, motion))
        same_way = was * asked > 0.0
        most = (abs(was) if same_way else 0.0) + max(0.0, acceleration * dt_s)
        assert abs(now) == min(abs(asked), most)
        assert now * asked >= 0.0


@given(MOTIONS, st.floats(1e-3, 1e3), st.floats(0.0, 1.0))
def test_no_acceleration_delays_a_stop(before: Motion, acceleration: float, dt_s: float):
    assert eased(before, STANDSTILL, acceleration, dt_s) == STANDSTILL


@pytest.mark.parametrize("name", NAMES)
def test_limits_that_are_none_are_refused(name: str):
    for speed in (-1.0, math.nan):
        with pytest.raises(ContractError, match=name):
            BodyLimits(**{name: speed})


@pytest.mark.parametrize("name", ["acceleration_mps2", "valid_for_s"])
def test_an_acceleration_or_a_validity_of_nothing_is_refused(name: str):
    for value in (0.0, -1.0, math.nan):
        with pytest.raises(ContractError, match=name):
            BodyLimits(**{name: value})


def test_the_longest_validity_in_nanoseconds():
    assert BodyLimits().valid_for_ns == BodyLimits(valid_for_s=1e300).valid_for_ns == FOR_EVER_NS
    assert BodyLimits(valid_for_s=0.1).valid_for_ns == 100_000_000


def test_of_two_limits_the_smaller_one_counts():
    one, other = BodyLimits(1.0, 2.0, valid_for_s=0.5), BodyLimits(2.0, 1.0, 3.0, 4.0)
    assert one.narrowed(other) == BodyLimits(1.0, 1.0, 3.0, 4.0, 0.5)
