"""What a unit computes, against the library's functions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_trainer import units
from reflexarc_trainer.units import RELU
from support.compiled_calls import from_python

activate = from_python(units.activate)
exp_of_negative = from_python(units.exp_of_negative)
sigmoid = from_python(units.sigmoid)
tanh = from_python(units.tanh)


@settings(deadline=None)  # the first call compiles
@given(st.floats(-700.0, 0.0))
def test_exponential_is_the_librarys_to_the_last_bits(x: float) -> None:
    assert exp_of_negative(x) == pytest.approx(math.exp(x), rel=4e-16, abs=0.0)


@settings(deadline=None)
@given(st.floats(-1e300, 1e300))
def test_sigmoid_and_tanh_are_right_for_any_number(x: float) -> None:
    exact = 1.0 / (1.0 + math.exp(-x)) if x > -700.0 else 0.0
    assert sigmoid(x) == pytest.approx(exact, rel=1e-15, abs=1e-300)
    assert tanh(x) == pytest.approx(math.tanh(x), rel=0, abs=4e-16)


def test_numbers_that_are_none_stay_none() -> None:
    values = np.array([math.nan, -1.0, 2.0])
    activate(RELU, values)
    assert math.isnan(values[0])
    assert values[1:].tolist() == [0.0, 2.0]
    assert math.isnan(sigmoid(math.nan))
