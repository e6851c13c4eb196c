import math

import numpy as np

from reflexarc_runtime.policy.operators.error_function import error_function


def test_it_is_that_of_the_c_library_to_the_last_bits() -> None:
    x = np.concatenate([np.linspace(-7.0, 7.0, 20_001), np.logspace(-300, 2, 999), [0.5, -0.5]])
    expected = np.array([math.erf(number) for number in x])
    np.testing.assert_allclose(error_function(x), expected, rtol=1e-15, atol=0)


def test_the_ends() -> None:
    ends = np.array([np.inf, -np.inf, np.nan, -0.0])
    np.testing.assert_array_equal(error_function(ends), [1.0, -1.0, np.nan, -0.0])
