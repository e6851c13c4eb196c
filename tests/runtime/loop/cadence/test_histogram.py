from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.loop.cadence.histogram import ABSENT, Histogram, add_each
from reflexarc_runtime.messages.spread import Spread

times = st.one_of(st.integers(0, 200), st.integers(0, (1 << 40) - 1))


def of(values: list[int]) -> Histogram:
    histogram = Histogram()
    for value in values:
        add_each((value,), (histogram,))
    return histogram


def smallest_that_enough_do_not_exceed(values: list[int], per_mille: int) -> int:
    for value in sorted(values):
        if 1000 * sum(other <= value for other in values) >= per_mille * len(values):
            return value
    raise AssertionError


@settings(max_examples=150)
@given(st.lists(times, min_size=1, max_size=60))
def test_its_percentiles_are_the_sorted_times_to_a_sixty_fourth(values: list[int]):
    spread = of(values).spread()
    for per_mille, said in ((500, spread.p50_ns), (990, spread.p99_ns), (999, spread.p999_ns)):
        exact = smallest_that_enough_do_not_exceed(values, per_mille)
        assert abs(said - exact) <= exact / 64
    assert (spread.count, spread.max_ns) == (len(values), max(values))


@settings(max_examples=150)
@given(st.lists(times, min_size=1, max_size=60))
def test_its_octaves_count_the_times_by_their_bits(values: list[int]):
    spread = of(values).spread()
    bits = Counter(value.bit_length() for value in values)
    assert spread.least_bits == min(bits)
    expected = [bits.get(n, 0) for n in range(min(bits), max(bits) + 1)]
    assert list(spread.octaves) == expected


@given(st.lists(times, max_size=30), st.lists(times, max_size=30))
def test_two_together_are_as_if_all_had_been_counted_by_one(some: list[int], others: list[int]):
    both = of(some)
    both.take(of(others))
    assert both.spread() == of(some + others).spread()


def test_every_bucket_of_a_power_of_two_is_used_evenly():
    counts = np.asarray(of(list(range(1 << 11))).counts)
    assert counts[:64].tolist() == [1] * 64
    assert counts[64:96].tolist() == [2] * 32  # 64 to 127
    assert counts[192:224].tolist() == [32] * 32  # 1024 to 2047


def test_a_time_beyond_all_buckets_is_in_the_last_one_and_known_as_the_largest():
    spread = of([1 << 50, 1 << 62]).spread()
    assert (spread.count, spread.max_ns, sum(spread.octaves)) == (2, 1 << 62, 2)


def test_what_is_absent_is_not_counted():
    assert of([ABSENT, ABSENT]).spread() == Spread()
    assert of([ABSENT, -(1 << 30), 5]).spread().count == 1


def test_each_time_goes_to_its_own_histogram():
    two = Histogram(), Histogram()
    add_each((1000, ABSENT), two)
    assert [histogram.spread().count for histogram in two] == [1, 0]
    with pytest.raises(ValueError, match="zip"):
        add_each((1, 2, 3), two)
