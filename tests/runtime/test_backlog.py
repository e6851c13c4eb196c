"""A queue is noticed by its delay alone, whatever the two clocks say."""

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.backlog import WINDOW_NS, LeastDelay, least_after

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
