from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.native.intrinsics import multiply_add

numbers = st.floats(-1e6, 1e6, allow_subnormal=False)


@compiled
def of_doubles(a: float, b: float, c: float) -> float:
    return multiply_add(a, b, c)  # type: ignore[no-any-return]  # an intrinsic has no types


@given(numbers, numbers, numbers)
def test_it_rounds_once(a: float, b: float, c: float) -> None:
    assert of_doubles(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))


def test_the_product_is_not_rounded_before() -> None:
    almost = 1.0 + 2.0**-30
    assert of_doubles(almost, almost, -1.0 - 2.0**-29) == 2.0**-60


def test_it_keeps_single_precision() -> None:
    third = np.float32(1.0 / 3.0)
    exact = Fraction(float(third)) * 3 - 1
    assert of_doubles(third, np.float32(3.0), np.float32(-1.0)) == float(exact)
