"""Step rules: what bounds them, and where a trace vanishes."""

import math
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_trainer.sarsa.online import traces
from support.compiled_calls import from_python

bounded_step = from_python(traces.bounded_step)
move_intentionally = from_python(traces.move_intentionally)


def test_a_vanishing_trace_moves_nothing() -> None:
    """The intentional step divides by Σ s e², which single precision would lose."""
    weights, trace = np.ones(32, np.float32), np.full(32, 1e-21, np.float32)
    trace[16:] = 0.0
    nothing = np.zeros_like(weights)
    move_intentionally(weights, trace, nothing.copy(), nothing, 0.5)
    np.testing.assert_array_equal(weights, 1.0)


@settings(deadline=None)  # the first call compiles
@given(
    trace=st.lists(st.floats(-50, 50), min_size=4, max_size=40),
    td_error=st.floats(-100, 100),
    data=st.data(),
)
def test_bounded_step_never_overshoots(trace: list[float], td_error: float, data: Any) -> None:
    """A linear value with features in [−1, 1] moves by at most 1/κ of the TD error."""
    features = data.draw(st.lists(st.floats(-1, 1), min_size=len(trace), max_size=len(trace)))
    step = bounded_step(1000.0, 2.0, td_error, math.fsum(map(abs, trace)))
    correction = step * td_error * np.dot(trace, features)
    assert abs(correction) <= abs(td_error) / 2.0 * (1 + 1e-9)


def test_bounded_step_is_never_above_alpha() -> None:
    assert bounded_step(0.5, 2.0, 0.1, 1e-3) == 0.5
    assert bounded_step(0.5, 2.0, 0.1, 0.0) == 0.5
    assert bounded_step(0.5, 2.0, 4.0, 5.0) == 1 / (2 * 4 * 5)
