"""A queue is noticed by its delay alone, whatever the two clocks say."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.backlog import NO_LAG, WINDOW_NS, LeastDelay, least_after

MS = 1_000_000


def behind_ms(delays_ms: list[int], period_ms: int = 20, offset_ms: int = 0) -> list[int]:
    """How far behind each message of a stream is found to be."""
    known: LeastDelay | None = None
    found = []
    for number, delay_ms in enumerate(delays_ms):
        delay_ns = (delay_ms + offset_ms) * MS
        known = least_after(known, delay_ns, (number * period_ms + delay_ms) * MS)
        found.append(known.behind_ns(delay_ns) // MS)
    return found


def test_a_queue_that_fills_is_as_old_as_it_is_deep():
    assert behind_ms([3, 3, 40, 300, 2003]) == [0, 0, 37, 297, 2000]


@given(st.lists(st.integers(0, 5000), min_size=1, max_size=50), st.integers(-(10**9), 10**9))
def test_the_clocks_do_not_matter(delays_ms: list[int], offset_ms: int):
    assert behind_ms(delays_ms, offset_ms=offset_ms) == behind_ms(delays_ms)


@given(st.lists(st.integers(0, 5000), min_size=1, max_size=50))
def test_it_is_the_delay_beyond_the_least_one_so_far(delays_ms: list[int]):
    expected = [d - min(delays_ms[: i + 1]) for i, d in enumerate(delays_ms)]
    assert behind_ms(delays_ms) == expected


def test_a_clock_that_drifts_is_followed_within_two_windows():
    drift = [number // 50 for number in range(3 * 3000)]  # 1 ms a second, for three minutes
    assert max(behind_ms(drift)) <= 2 * WINDOW_NS // 1_000_000_000


def test_a_queue_that_stays_is_not_forgotten_for_a_long_time():
    delays_ms = [3] * 100 + [2003] * (10 * 60 * 50)  # ten minutes
    behind = behind_ms(delays_ms)
    assert min(behind[100:]) >= 2000 - 11 * 60  # what two clocks may drift apart meanwhile


SILENCE_NS = 400 * MS
Steps = list[tuple[int, int]]


def stream(delays_ms: list[int], steps: Steps, period_ms: int = 100):
    """Arrivals and stamps (ns) of a queue in order; its sender's clock steps before some messages.

    Args:
        delays_ms: of each message on its way, if none before it comes later.
        steps: number of a message, and by how many milliseconds the clock steps before it.
        period_ms: of the sender.
    """
    arrived_ms = 0
    for number, delay_ms in enumerate(delays_ms):
        sent_ms = 100_000 + number * period_ms
        arrived_ms = max(arrived_ms, sent_ms + delay_ms)
        clock_ms = sent_ms + sum(step for at, step in steps if at <= number)
        yield arrived_ms, arrived_ms - sent_ms, clock_ms


@given(
    st.lists(st.integers(0, 300), min_size=2, max_size=60),
    st.lists(st.tuples(st.integers(1, 59), st.sampled_from([-3000, 60_000])), max_size=3),
)
def test_no_step_of_the_sender_s_clock_makes_a_picture_younger(delays_ms: list[int], steps: Steps):
    known, least_ms = NO_LAG, 10**9
    for arrived_ms, true_ms, clock_ms in stream(delays_ms, steps):
        known = known.after(clock_ms * MS, arrived_ms * MS, SILENCE_NS)
        least_ms = min(least_ms, true_ms)
        assert known.behind_ns >= (true_ms - least_ms) * MS


@pytest.mark.parametrize("step_ms", [-3000, 3000])
def test_after_a_step_a_steady_stream_is_believed_again(step_ms: int):
    known, found = NO_LAG, []
    for arrived_ms, _, clock_ms in stream([5] * 300, [(50, step_ms)], period_ms=20):
        known = known.after(clock_ms * MS, arrived_ms * MS, SILENCE_NS)
        found.append(known.behind_ns // MS)
    assert found[:50] == [0] * 50
    assert set(found[50:]) == {20}  # as if it had been sent right behind the one before


def test_without_stamps_nothing_is_known_and_age_counts_from_the_arrival():
    known = NO_LAG
    for number in range(100):
        known = known.after(0, number * 20 * MS, SILENCE_NS)
        assert known.behind_ns == 0


def test_stamps_that_end_leave_a_queue_as_deep_as_it_was():
    known = NO_LAG
    for number, delay_ms in enumerate([0, 0, 2000]):
        stamp_ms = 1000 + 20 * number
        known = known.after(stamp_ms * MS, (stamp_ms + delay_ms) * MS, SILENCE_NS)
    for number in range(10):
        known = known.after(0, (3060 + 20 * number) * MS, SILENCE_NS)
    assert known.behind_ns >= 2000 * MS


def test_a_stamp_that_never_changes_is_an_old_picture_again_and_again():
    known = NO_LAG
    for number in range(101):
        known = known.after(7, number * 20 * MS, SILENCE_NS)
    assert known.behind_ns == 2000 * MS


def test_a_sender_that_began_anew_is_believed_after_its_silence():
    known = NO_LAG
    for number in range(50):
        known = known.after((10**6 + 20 * number) * MS, 20 * number * MS, SILENCE_NS)
    for number in range(50):  # a microcontroller: its clock begins at 0
        at_ms = 2000 + 20 * number
        known = known.after((1 + 20 * number) * MS, at_ms * MS, SILENCE_NS)
        assert known.behind_ns == 0


def test_messages_that_were_overtaken_in_a_queue_do_not_pass_for_a_clock_s_step():
    known = NO_LAG.after(10 * MS, 10 * MS, SILENCE_NS)
    sequence, behind = 0, []
    for place in range(1, 200):
        number = place + 1 if place % 2 else place - 1  # 2, 1, 4, 3, …
        overtaken, sequence = number < sequence, number
        stamp_ms = 10 + 20 * number
        arrived_ms = 2000 + 20 * (place + 1)
        known = known.after(stamp_ms * MS, arrived_ms * MS, SILENCE_NS, overtaken=overtaken)
        behind.append(known.behind_ns // MS)
    assert min(behind) >= 1950


@given(st.lists(st.integers(0, 40), min_size=200, max_size=200))
@settings(deadline=None)
def test_over_many_windows_it_is_the_least_delay_s_own_account(delays_ms: list[int]):
    known, least = NO_LAG, None
    for number, delay_ms in enumerate(delays_ms):
        stamp_ms = 1 + 1000 * number  # three windows
        arrived_ns = (stamp_ms + delay_ms) * MS
        known = known.after(stamp_ms * MS, arrived_ns, SILENCE_NS)
        least = least_after(least, delay_ms * MS, arrived_ns)
        assert known.least == least
        assert known.behind_ns == least.behind_ns(delay_ms * MS)
