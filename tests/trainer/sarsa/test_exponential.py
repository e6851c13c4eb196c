"""The exponential function, against the library's."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_trainer.sarsa import exponential
from support.compiled_calls import from_python

exp_of_negative = from_python(exponential.exp_of_negative)


@settings(deadline=None)  # the first call compiles
@given(st.floats(-700.0, 0.0))
def test_exponential_is_the_librarys_to_the_last_bits(x: float) -> None:
    assert exp_of_negative(x) == pytest.approx(math.exp(x), rel=5e-16, abs=0.0)


@settings(deadline=None)
@given(st.floats(-87.0, 0.0, width=32))
def test_exponential_is_the_librarys_in_single_precision_too(x: float) -> None:
    assert exp_of_negative(np.float32(x)) == pytest.approx(math.exp(x), rel=2e-7, abs=0.0)


def test_single_precision_is_computed_in_single_precision() -> None:
    found = [exp_of_negative(np.float32(x)) for x in np.linspace(-20.0, 0.0, 50)]
    assert all(value == np.float32(value) for value in found)
