"""When a moving body touches a point: by hand, and against a sweep the long way."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.sweep import touch_times_s
from support.slow_sweep import first_touch_s

POINT, DISC = Footprint(), Footprint(radius_m=0.2)
CART = Footprint(ahead_m=0.4, behind_m=0.1, half_width_m=0.2)


def touched_s(x, y, footprint, twist, margin_m=0.0):
    return float(touch_times_s(np.array([x]), np.array([y]), footprint, margin_m, twist)[0])


@pytest.mark.parametrize(
    ("x", "y", "footprint", "twist", "expected"),
    [
        (1.0, 0.0, DISC, (2.0, 0.0, 0.0), 0.4),  # 0.8 m at 2 m/s
        (1.0, 0.2, DISC, (1.0, 0.0, 0.0), math.inf),  # passes at its rim
        (1.0, 0.12, DISC, (1.0, 0.0, 0.0), 0.84),  # 0.16² + 0.12² = 0.2²
        (-0.5, 0.0, DISC, (1.0, 0.0, 0.0), math.inf),  # behind
        (0.0, 1.0, DISC, (0.0, -1.0, 0.0), math.inf),  # moves away from it
        (0.0, -1.0, DISC, (0.0, -1.0, 0.0), 0.8),  # sideways
        (1.0, 1.0, DISC, (1.0, 0.0, 1.0), math.pi / 2 - 2 * math.asin(0.1)),  # on its circle
        (0.3, 0.0, DISC, (0.0, 0.0, 5.0), math.inf),  # a disc on the spot sweeps nothing
        (1.0, 0.19, CART, (1.0, 0.0, 0.0), 0.6),  # its front is 0.4 ahead
        (1.0, 0.21, CART, (1.0, 0.0, 0.0), math.inf),
        (0.0, 0.5, CART, (0.0, 1.0, 0.0), 0.3),
        (0.0, 0.42, CART, (0.0, 0.0, 1.0), math.acos(0.2 / 0.42)),  # its left side, on the spot
        (-0.5, 0.0, CART, (-1.0, 0.0, 0.0), 0.4),
    ],
)
def test_touches_by_hand(x, y, footprint, twist, expected):
    assert touched_s(x, y, footprint, twist) == pytest.approx(expected, abs=1e-9)


def test_the_margin_widens_the_outline():
    assert touched_s(1.0, 0.0, DISC, (1.0, 0.0, 0.0), 0.05) == pytest.approx(0.75)
    assert touched_s(1.0, 0.0, CART, (1.0, 0.0, 0.0), 0.05) == pytest.approx(0.55)


@pytest.mark.parametrize("footprint", [POINT, DISC, CART])
@pytest.mark.parametrize("angular", [0.0, 0.8, -0.8])
def test_whoever_stands_too_near_may_leave_and_not_come_nearer(footprint, angular):
    ahead_m = footprint.radius_m + footprint.ahead_m + 0.02
    assert touched_s(ahead_m, 0.0, footprint, (1.0, 0.0, angular), 0.05) <= 0.0
    assert touched_s(ahead_m, 0.0, footprint, (-1.0, 0.0, angular), 0.05) > 1.0


def test_an_almost_straight_arc_is_as_the_straight_line():
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-3, 3, (2, 500))
    for footprint in (DISC, CART):
        straight = touch_times_s(x, y, footprint, 0.05, (1.0, 0.3, 0.0))
        for angular in (1e-7, -1e-7, 2e-5, -2e-5):
            bent = touch_times_s(x, y, footprint, 0.05, (1.0, 0.3, angular))
            both = np.isfinite(straight) & (bent < 6.0)
            assert both.sum() > 20
            assert np.quantile(np.abs(straight.clip(0.0)[both] - bent.clip(0.0)[both]), 0.98) < 1e-3
            assert (np.isfinite(straight) != (bent < 6.0)).sum() <= 1


speeds = st.integers(-150, 150).map(lambda v: 0.0 if abs(v) < 5 else v / 100.0)
twists = st.tuples(speeds, speeds, speeds)
sides = st.integers(-2000, 2000).map(lambda millimetres: millimetres / 1000.0 + 1e-5)
places = st.tuples(sides, sides)
points = places.filter(lambda at: math.hypot(*at) > 1e-3)  # in the middle, no way leads away
STEP_S, UNTIL_S = 0.002, 1.6


@settings(max_examples=150, deadline=None)
@given(
    st.lists(points, min_size=1, max_size=8),
    st.sampled_from([POINT, DISC, CART]),
    st.sampled_from([0.0, 0.05, 0.2]),
    twists,
)
def test_it_is_what_a_slow_sweep_finds(cloud, footprint, margin_m, twist):
    x, y = np.array(cloud).T
    quick = float(touch_times_s(x, y, footprint, margin_m, twist).min())
    slow = first_touch_s(cloud, footprint, margin_m, twist, UNTIL_S, STEP_S)
    if slow == 0.0 or quick <= 0.0:
        near = touch_times_s(x, y, footprint, margin_m + 1e-6, twist).min()
        assert quick <= 0.0 or near <= 0.0 or quick < STEP_S
        assert slow <= STEP_S or _grazes(cloud, footprint, margin_m, twist)
    elif slow <= UNTIL_S:
        assert quick <= slow + 1e-9
        assert slow - STEP_S <= quick + 1e-9 or _grazes(cloud, footprint, margin_m, twist)
    else:
        assert quick > UNTIL_S or _grazes(cloud, footprint, margin_m, twist)


def _grazes(cloud, footprint, margin_m, twist):
    """Whether the slow sweep stepped over a point that is touched for less than a step."""
    finer = first_touch_s(cloud, footprint, margin_m + 2e-3, twist, UNTIL_S, STEP_S / 8)
    x, y = np.array(cloud).T
    quick = float(touch_times_s(x, y, footprint, margin_m, twist).min())
    return finer <= max(quick, 0.0) + STEP_S
