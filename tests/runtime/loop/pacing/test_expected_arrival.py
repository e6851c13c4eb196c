"""The guess of the next arrival, against sensors whose times are known."""

import numpy as np
import pytest

from reflexarc_runtime.loop.pacing.expected_arrival import ExpectedArrival
from support.sensing import MS

P = 20 * MS


def guessed(arrivals_ns: list[int]) -> ExpectedArrival:
    expected = ExpectedArrival()
    for at_ns in arrivals_ns:
        expected.came(at_ns)
    return expected


def test_of_one_arrival_or_none_nothing_follows():
    assert guessed([]).next_ns() is None
    assert guessed([5 * MS]).next_ns() is None


def test_an_even_sensor_is_foreseen_exactly_whatever_its_rate():
    for period_ns in (MS, P, 3 * P + 7):
        assert guessed([period_ns * n for n in range(1, 9)]).next_ns() == 9 * period_ns


def test_one_late_arrival_hardly_moves_the_next():
    expected = guessed([*(n * P for n in range(1, 9)), 9 * P + 4 * MS])
    assert expected.next_ns() == 10 * P + MS + MS // 8  # a quarter of it; and an eighth of 1 ms


@pytest.mark.parametrize("jitter_ns", [MS // 10, MS, 3 * MS])
def test_what_jitters_comes_hardly_ever_before_it_is_expected(jitter_ns: int):
    jitters = np.random.default_rng(3).integers(-jitter_ns, jitter_ns, 2000).tolist()
    expected, early, waits_ns = ExpectedArrival(), 0, []
    for n, jitter in enumerate(jitters, 1):
        next_ns, at_ns = expected.next_ns(), n * P + jitter
        if n > 200 and next_ns is not None:
            early += at_ns < next_ns
            waits_ns.append(at_ns - next_ns)
        expected.came(at_ns)
    assert len(waits_ns) > 1700
    assert early < 0.1 * len(waits_ns)
    assert np.median(waits_ns) < 2 * jitter_ns


def test_what_comes_at_any_time_is_not_foreseen():
    at_ns = np.cumsum(np.random.default_rng(4).exponential(P, 500)).astype(int).tolist()
    expected, known = ExpectedArrival(), 0
    for each in at_ns:
        expected.came(each)
        known += expected.next_ns() is not None
    assert known < 0.5 * len(at_ns)


def test_after_a_loss_or_another_rate_it_is_foreseen_again():
    assert guessed([P, 2 * P, 4 * P, 5 * P, 6 * P]).next_ns() == 7 * P
    quicker = [3 * P + n * P // 8 for n in range(1, 5)]
    assert guessed([P, 2 * P, 3 * P, *quicker]).next_ns() == 3 * P + 5 * P // 8
