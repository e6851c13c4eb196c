from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.vision.shading import quotient

Floats = npt.NDArray[np.float64]

ranges_m = st.floats(1e-3, 1e6)
distances_m = st.floats(0.0, 1e6, width=32)


@compiled
def quotients(a: Floats, b: float, out: Floats) -> None:
    for k in range(len(a)):
        out[k] = quotient(a[k], b, 1.0 / b)


def divided(a: Floats, b: float) -> Floats:
    out = np.empty_like(a)
    quotients(a, b, out)
    return out


@settings(deadline=None)  # it compiles at first
@given(distances_m, ranges_m)
@example(5.0, np.nextafter(2.0, 0.0))  # its reciprocal lies nearly halfway between two float64
def test_it_is_the_float64_nearest_to_the_exact_one(distance_m: float, range_m: float) -> None:
    exact = Fraction(distance_m) / Fraction(range_m)
    assert divided(np.array([distance_m]), range_m)[0] == float(exact)


@pytest.mark.parametrize("whole", [255, 255_000])
def test_every_share_of_a_colour(whole: int) -> None:
    parts = np.arange(whole + 1, dtype=np.float64)
    np.testing.assert_array_equal(divided(parts, whole), parts / whole)


def test_many_distances_in_many_ranges() -> None:
    draws = np.random.default_rng(0)
    for range_m in draws.uniform(0.1, 50.0, 40):
        distances = draws.uniform(0.0, range_m, 50_000).astype(np.float32).astype(np.float64)
        np.testing.assert_array_equal(divided(distances, range_m), distances / range_m)
