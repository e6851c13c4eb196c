import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.importing.scan_times import EvenTimes, RecordedTimes

S = 1_000_000_000


@given(st.integers(1, 1000), st.integers(0, 10_000))
def test_even_times_never_drift(rate: int, count: int):
    times = EvenTimes(float(rate))
    for _ in range(count):
        times.of(None, 0)
    assert abs(times.of(None, 0) * rate - count * S) <= rate / 2 + 1


@given(st.lists(st.integers(1, 600 * S), max_size=20), st.integers(-S, S))
def test_recorded_times_are_sums_of_their_steps(steps: list[int], first_ns: int):
    times = RecordedTimes()
    recorded = first_ns + np.cumsum([0, *steps])
    assert [times.of(int(t), 0) for t in recorded] == np.cumsum([0, *steps]).tolist()
    assert times.fault() == ""
