import itertools

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.loop.throttle import SECOND_NS, Throttle

TIMES_NS = st.lists(st.integers(0, 10 * SECOND_NS), min_size=1).map(sorted)


def due_at(throttle: Throttle, times_ns: list[int]) -> list[int]:
    return [time_ns for time_ns in times_ns if throttle.is_due(time_ns)]


def test_the_first_message_is_due_at_once_and_the_next_a_second_later():
    times_ns = [7, 8, SECOND_NS + 6, SECOND_NS + 7, SECOND_NS + 8]
    assert due_at(Throttle(), times_ns) == [7, SECOND_NS + 7]


def test_the_first_message_can_wait_for_a_whole_period():
    assert due_at(Throttle(100, at_once=False), [7, 8, 106, 107, 206, 207]) == [107, 207]


def test_messages_that_were_missed_are_not_caught_up_with():
    assert due_at(Throttle(100), [0, 950, 960, 1049, 1050]) == [0, 950, 1050]


@given(TIMES_NS)
def test_there_is_always_a_period_between_two_messages(times_ns: list[int]):
    due = due_at(Throttle(), times_ns)
    assert due[0] == times_ns[0]
    assert all(later - earlier >= SECOND_NS for earlier, later in itertools.pairwise(due))
