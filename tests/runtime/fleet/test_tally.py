"""Times of a phase summed over many statuses, against the times themselves."""

from bisect import bisect_left

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.fleet.tally import BOUNDS_S, PhaseTally
from reflexarc_runtime.loop.cadence.histogram import Histogram, add_each

times = st.integers(0, 1 << 36)


@given(st.lists(st.lists(times, max_size=20), max_size=4))
def test_its_buckets_count_the_times_below_each_bound(periods: list[list[int]]):
    tally = PhaseTally()
    for period in periods:
        histogram = Histogram()
        for time_ns in period:
            add_each((time_ns,), (histogram,))
        tally.add(histogram.spread())
    everything = sorted(time_ns for period in periods for time_ns in period)
    below = [bisect_left(everything, round(bound_s * 1e9)) for bound_s in BOUNDS_S]
    assert tally.cumulative == [*below, len(everything)]
    exact_s = sum(everything) * 1e-9
    assert abs(tally.sum_s - exact_s) <= exact_s / 64 + 1e-12
