"""Streams by hand: what is regular, what is a gap, what is missing."""

from collections.abc import Iterable

import pytest

from reflexarc_logs.checking.stream_course import StreamCourse

MS = 1_000_000


def course(times_ms: Iterable[float], numbers: Iterable[int] | None = None) -> StreamCourse:
    found, times = StreamCourse("/x"), list(times_ms)
    for number, at in zip(numbers or range(len(times)), times, strict=True):
        found.add(number, int(at * MS), int(at * MS))
    return found


def test_the_period_is_the_median_interval_to_a_hundredth() -> None:
    assert course(20.0 * k for k in range(100)).period_ns == pytest.approx(20 * MS, rel=0.01)


def test_what_comes_at_no_regular_time_has_no_period() -> None:
    assert course(1.5**k for k in range(40)).period_ns is None
    assert course(20.0 * k for k in range(10)).period_ns is None


@pytest.mark.parametrize(("silence_ms", "gap_ms"), [(90.0, 0), (120.0, 120)])
def test_a_gap_is_a_silence_of_more_than_five_periods(silence_ms: float, gap_ms: int) -> None:
    times = [20.0 * k for k in range(50)]
    times += [times[-1] + silence_ms + 20.0 * k for k in range(50)]
    found = course(times)
    assert found.gap_ns == gap_ms * MS
    assert found.longest_ns == silence_ms * MS
    assert found.longest_at_ns == 980 * MS


@pytest.mark.parametrize(
    ("numbers", "lost"),
    [
        ([1, 2, 3, 4], 0),
        ([1, 2, 5, 6, 7], 2),
        ([1, 3, 2, 4, 5, 6], 0),  # late
        ([1, 2, 2, 3], 0),  # twice
        ([1, 2, 3, 4, 6, 5, 7, 9, 10, 11, 12], 1),
        ([100, 101, 102, 0, 1, 2], 0),  # a restart
        ([0, 10, 20, 30], 0),  # not counted one by one
        ([0, 0, 0, 0], 0),
    ],
)
def test_what_is_missing_by_its_numbers(numbers: list[int], lost: int) -> None:
    assert course((20.0 * k for k in range(len(numbers))), numbers).lost == lost


def test_log_time_that_goes_back_is_counted() -> None:
    found = course([0, 20, 40, 30, 60, 10])
    assert (found.backs, found.most_back_ns) == (2, 50 * MS)
