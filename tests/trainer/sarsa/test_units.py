"""What a unit computes, against the library's functions."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_trainer.sarsa import units
from reflexarc_trainer.sarsa.units import RELU, SIGMOID, TANH
from support.compiled_calls import from_python

activate = from_python(units.activate)
ANY_NUMBER = st.floats(-1e300, 1e300) | st.floats(-40.0, 40.0)
SINGLE = st.floats(-(2.0**100), 2.0**100, width=32) | st.floats(-40.0, 40.0, width=32)


def activated(kind: int, x: float, dtype: npt.DTypeLike) -> float:
    values = np.array([x], dtype)
    activate(kind, values)
    return float(values[0])


def logistic(x: float) -> float:
    return 1.0 / (1.0 + math.exp(-x)) if x > -700.0 else 0.0


@settings(deadline=None)
@given(ANY_NUMBER)
def test_sigmoid_and_tanh_are_right_for_any_number(x: float) -> None:
    assert activated(SIGMOID, x, np.float64) == pytest.approx(logistic(x), rel=1e-15, abs=1e-300)
    assert activated(TANH, x, np.float64) == pytest.approx(math.tanh(x), rel=0, abs=4e-16)


@settings(deadline=None)
@given(SINGLE)
def test_sigmoid_and_tanh_are_right_in_single_precision_too(x: float) -> None:
    assert activated(SIGMOID, x, np.float32) == pytest.approx(logistic(x), rel=4e-7, abs=1e-37)
    assert activated(TANH, x, np.float32) == pytest.approx(math.tanh(x), rel=0, abs=2e-7)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_whole_vectors_and_their_rest_are_what_single_numbers_are(dtype: npt.DTypeLike) -> None:
    values = np.linspace(-30.0, 30.0, 37).astype(dtype)
    for kind, exact in ((SIGMOID, 1.0 / (1.0 + np.exp(-values))), (TANH, np.tanh(values))):
        mine = values.copy()
        activate(kind, mine)
        np.testing.assert_allclose(mine, exact, rtol=4 * np.finfo(dtype).eps, atol=0)


def test_numbers_that_are_none_stay_none() -> None:
    values = np.array([math.nan, -1.0, 2.0])
    activate(RELU, values)
    assert math.isnan(values[0])
    assert values[1:].tolist() == [0.0, 2.0]
    assert math.isnan(activated(SIGMOID, math.nan, np.float64))
    assert math.isnan(activated(SIGMOID, math.nan, np.float32))
