"""Which ticks are missing, and which stand where they should not."""

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.replaying.tick_order import TickOrder
from reflexarc_runtime.messages_pb2 import Command, Decision


def order_of(numbers: list[int], *, ended: bool = True) -> TickOrder:
    order = TickOrder()
    for place, number in enumerate(numbers):
        last = ended and place == len(numbers) - 1
        verdict = "STOPPED" if last else "OK"
        order.saw(Decision(index=number, verdict=verdict, command=Command(sequence=number)))
    return order


@given(kept=st.sets(st.integers(0, 60), min_size=1))
def test_what_lies_between_two_ticks_and_is_not_there_is_missing(kept):
    numbers = sorted(kept)
    order = order_of(numbers)
    absent = set(range(numbers[0], numbers[-1])) - kept
    assert (order.missing, order.behind, order.first) == (len(absent), 0, numbers[0])
    assert not absent or order.first_missing == min(absent)


def test_a_whole_run_has_nothing_to_say():
    assert list(order_of([0, 1, 2, 3]).notes()) == []
    assert list(TickOrder().notes()) == []


def test_what_is_not_there_at_either_end_is_said():
    assert list(order_of([5, 6], ended=False).notes()) == [
        "it holds ticks 5 to 6: what came before and after is not in it"
    ]


def test_ticks_that_stand_twice_or_too_late_are_counted_and_none_is_missing_for_it():
    order = order_of([0, 1, 1, 2, 4, 3, 5])
    assert (order.behind, order.missing, order.restarts) == (2, 1, 0)
    assert list(order.notes())[-1] == "2 ticks stand twice, or out of order"


def test_another_run_is_a_restart_whose_own_gaps_are_found():
    order = order_of([0, 1, 2, 0, 1, 4])
    assert (order.restarts, order.behind, order.missing, order.first_missing) == (1, 1, 2, 2)


def test_a_number_that_one_place_tells_wrongly_is_no_gap():
    order = TickOrder()
    for index, sequence in ((0, 0), (1000, 1), (2, 2), (3, 77), (4, 4)):
        order.saw(Decision(index=index, command=Command(sequence=sequence)))
    assert (order.missing, order.behind) == (0, 0)
