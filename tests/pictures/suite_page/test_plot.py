import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_pictures.suite_page.plot import Scale, round_step, shortened, spread_out

PLACES = st.lists(st.floats(-50.0, 450.0), min_size=1, max_size=30)


@given(PLACES)
def test_names_keep_their_order_their_distance_and_their_bounds(wanted: list[float]):
    places = spread_out(wanted, 15.0, 0.0, 400.0)
    order = sorted(range(len(wanted)), key=lambda k: (wanted[k], k))
    apart = min(15.0, 400.0 / max(len(wanted) - 1, 1))
    assert min(places) >= -1e-6
    assert max(places) <= 400.0 + 1e-6
    for before, after in pairwise(order):
        assert places[after] - places[before] >= apart - 1e-6


def test_names_that_are_far_apart_stay_where_they_are():
    assert spread_out([300.0, 10.0, 150.0], 15.0, 0.0, 400.0) == [300.0, 10.0, 150.0]


def test_a_scale_is_linear_and_ends_at_its_ends():
    scale = Scale(0.0, 2.0, 100.0, 300.0)
    assert [scale.at(v) for v in (-1.0, 0.0, 0.5, 2.0, 9.0)] == [100.0, 100.0, 150.0, 300.0, 300.0]
    assert scale.ticks(4) == [0.0, 0.5, 1.0, 1.5, 2.0]


@pytest.mark.parametrize(
    ("least", "step"), [(0.03, 0.05), (0.2, 0.2), (0.21, 0.5), (7.0, 10.0), (1.0, 1.0), (11, 20)]
)
def test_steps_between_ticks_are_1_2_or_5(least: float, step: float):
    assert math.isclose(round_step(least), step)


def test_a_long_name_keeps_its_end():
    assert shortened("runs/reflex-0/policy.onnx", 12) == "\u2026policy.onnx"
    assert shortened("short", 12) == "short"
