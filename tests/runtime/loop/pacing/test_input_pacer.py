"""The pacer on scripts of arrivals: exact, and on no clock of this machine."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.loop.bell import Bell, LockBell
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing import input_pacer
from reflexarc_runtime.loop.pacing.input_pacer import InputPacer, may_leave_one_out
from reflexarc_runtime.loop.pacing.pacer import PATIENCE_NS, Wakeup
from reflexarc_runtime.messages.topics import OVERRUN, RESET, RETINA, SCAN, STOP, Topic
from reflexarc_runtime.messages.wire import Message
from support.policies import SMALL
from support.sensing import MS

P = 20 * MS
HALF = P // 2
RATE_HZ = 50.0
NEVER = bool  # bool() is False


class Loop:
    """A pacer, and arrivals that a script names; ticks take no time, or as long as is said."""

    def __init__(self, *, leaves_out: bool = True, oversleep_ns: int = 0) -> None:
        self.clock, self.inbox = ManualClock(oversleep_ns=oversleep_ns), Inbox()
        self.pacer = InputPacer(RATE_HZ, self.clock, self.inbox, RETINA, leaves_out=leaves_out)

    def arrive(self, times_ns: Iterable[int], topic: Topic = RETINA) -> None:
        for at_ns in times_ns:
            message = Message(topic.key("robot0"), b"", "", b"", at_ns)
            self.clock.at_ns(at_ns, lambda message=message: self.inbox.put(message))  # type: ignore[misc]

    def ticks(self, count: int, works_ns: Iterable[int] = ()) -> list[Wakeup]:
        works, seen = iter(works_ns), []
        for _ in range(count):
            wakeup = self.pacer.wait(NEVER)
            assert wakeup is not None
            seen.append(wakeup)
            self.clock.advance_to_ns(self.clock.time_ns + next(works, 0))
        return seen


def times_ms(ticks: Iterable[Wakeup]) -> list[float]:
    return [tick.wake_ns / MS for tick in ticks]


def test_a_tick_begins_when_an_input_arrives_and_at_its_deadline_without_one():
    loop = Loop()
    loop.arrive(at * MS for at in (12, 31, 45, 52, 95))
    ticks = loop.ticks(6)
    # T is 20, 40, 60, 80, 100, 120 ms; 45 ms is before 60 − 10: the next input is waited for.
    assert times_ms(ticks) == [12, 31, 52, 90, 95, 130]
    assert [tick.slot for tick in ticks] == [1, 2, 3, 4, 5, 6]
    assert [len(tick.messages) for tick in ticks] == [1, 1, 2, 0, 1, 0]
    assert {tick.wake_ns - tick.deadline_ns for tick in ticks} == {0}


def test_a_sensor_slower_than_the_rate_sees_ticks_in_between():
    loop = Loop()
    loop.arrive(range(P, 20 * P, 2 * P))  # 25 Hz
    ticks = loop.ticks(16)
    with_input = [tick for tick in ticks if tick.messages]
    assert {tick.wake_ns - tick.messages[-1].received_ns for tick in with_input} == {0}
    assert len(with_input) == 8
    assert ticks[-1].wake_ns - ticks[0].wake_ns == 15 * P + HALF


def slow_model(arrivals: list[int], count: int) -> list[int]:
    """When ticks begin that take no time, word by word as the module says it."""
    nominal, last, times = P, -1, []
    for _ in range(count):
        fit = [a for a in arrivals if nominal - HALF <= a <= nominal + HALF and a > last]
        begins = min(fit, default=nominal + HALF)
        nominal = (max(begins, nominal) if fit else nominal) + P
        times.append(begins)
        last = begins
    return times


arrivals = st.lists(st.integers(1, 60 * MS), max_size=40).map(
    lambda gaps: [sum(gaps[: n + 1]) for n in range(len(gaps))]
)


@settings(max_examples=100, deadline=None)
@given(arrivals)
def test_ticks_begin_as_a_slow_model_of_the_rule_says(times: list[int]):
    loop = Loop()
    loop.arrive(times)
    assert [tick.wake_ns for tick in loop.ticks(30)] == slow_model(times, 30)


@settings(max_examples=100, deadline=None)
@given(arrivals, st.booleans())
def test_the_rate_is_never_exceeded_and_the_deadline_is_kept(times: list[int], leaves_out: bool):
    loop = Loop(leaves_out=leaves_out)
    loop.arrive(times)
    ticks = loop.ticks(30)
    for n, tick in enumerate(ticks, 1):
        assert tick.wake_ns >= n * P - HALF  # n ticks since the beginning: n periods, but one half
    for i, one in enumerate(ticks):
        for j, other in enumerate(ticks[i + 1 :], 1):
            assert other.wake_ns - one.wake_ns >= (j - 1) * P
    assert all(b.wake_ns - a.wake_ns <= 2 * P for a, b in pairwise(ticks))


@settings(max_examples=100, deadline=None)
@given(arrivals, st.lists(st.integers(0, 90 * MS), max_size=30), st.integers(0, P), st.booleans())
def test_slow_ticks_and_a_machine_that_oversleeps_make_no_burst(
    times: list[int], works: list[int], oversleep_ns: int, leaves_out: bool
):
    loop = Loop(leaves_out=leaves_out, oversleep_ns=oversleep_ns)
    loop.arrive(times)
    ticks = loop.ticks(30, works)
    for i, one in enumerate(ticks):
        for j, other in enumerate(ticks[i + 1 :], 1):
            assert other.wake_ns - one.wake_ns >= (j - 2) * P
    assert all(a.slot < b.slot for a, b in pairwise(ticks))
    for tick in ticks:  # a slot is where its time is, however often the loop was late
        assert -0.5 <= tick.wake_ns / P - tick.slot < 2.5
    heard = [message.received_ns for tick in ticks for message in tick.messages]
    assert heard == times[: len(heard)]  # each once, in order
    assert all(tick.deadline_ns <= tick.wake_ns for tick in ticks)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(0, HALF), min_size=40, max_size=40))
def test_jitter_of_half_a_period_costs_no_latency(jitter_ns: list[int]):
    loop = Loop()
    loop.arrive(n * P + late for n, late in enumerate(jitter_ns, 1))
    ticks = loop.ticks(40)
    assert [len(tick.messages) for tick in ticks] == [1] * 40
    assert all(tick.wake_ns == tick.messages[0].received_ns for tick in ticks)


@pytest.mark.parametrize("period_ns", [P - 1, P - P // 1000, P - P // 10, 2 * P // 3, P // 7])
def test_no_picture_waits_however_much_quicker_than_the_rate_its_sensor_is(period_ns: int):
    loop = Loop()
    loop.arrive(range(period_ns, 3000 * P, period_ns))
    ticks = loop.ticks(2500)
    assert all(tick.wake_ns == tick.messages[-1].received_ns for tick in ticks)
    assert ticks[-1].wake_ns <= 2500 * P * 1.06  # little of the rate is lost


def test_where_no_input_may_be_left_out_a_quicker_sensor_s_pictures_wait():
    loop = Loop(leaves_out=False)
    loop.arrive(range(P - P // 100, 3000 * P, P - P // 100))
    ticks = loop.ticks(2500)
    ages = [tick.wake_ns - tick.messages[-1].received_ns for tick in ticks]
    assert max(ages) > 0.9 * P
    assert all(b.wake_ns - a.wake_ns <= P for a, b in pairwise(ticks[100:]))


def test_a_missed_deadline_is_counted_and_left_out():
    loop = Loop()
    ticks = loop.ticks(4, [0, 75 * MS])
    assert times_ms(ticks) == [30, 50, 125, 130]  # 70, 90 and 110 ms passed; 110 is begun late
    assert [tick.slot for tick in ticks] == [1, 2, 5, 6]
    assert [tick.missed for tick in ticks] == [0, 0, 2, 0]
    assert [tick.wake_ns - tick.deadline_ns for tick in ticks] == [0, 0, 55 * MS, 0]


def test_a_late_tick_leaves_the_next_input_its_tick():
    loop = Loop(oversleep_ns=12 * MS)
    loop.arrive(range(P, 40 * P, P))
    ticks = loop.ticks(30)
    assert [len(tick.messages) for tick in ticks] == [1] * 30
    assert {tick.wake_ns - tick.deadline_ns for tick in ticks} == {12 * MS}


def test_an_input_that_came_while_a_tick_took_long_begins_the_next_one_at_once():
    loop = Loop()
    loop.arrive([20 * MS, 55 * MS])
    ticks = loop.ticks(3, [40 * MS])
    assert times_ms(ticks)[:2] == [20, 60]
    assert ticks[1].deadline_ns == 55 * MS
    assert times_ms(ticks)[2] == 85  # the tick began late; its input moved T to 55 ms


@pytest.mark.parametrize("topic", [STOP, RESET, OVERRUN])
def test_what_stops_a_loop_begins_a_tick_as_soon_as_the_rate_allows(topic: Topic):
    loop = Loop()
    loop.arrive([20 * MS])
    loop.arrive([21 * MS, 53 * MS], topic)
    assert times_ms(loop.ticks(3)) == [20, 30, 53]


def test_a_ring_whose_message_a_tick_has_taken_begins_no_tick(monkeypatch: pytest.MonkeyPatch):
    """The thread that put it was held up in between."""
    monkeypatch.setattr(input_pacer, "new_bell", LockBell)
    loop, held = Loop(), list[Bell]()
    with monkeypatch.context() as meanwhile:
        meanwhile.setattr(LockBell, "ring", lambda bell: held.append(bell))
        loop.arrive([25 * MS])
        assert times_ms(loop.ticks(1)) == [30]  # at its deadline
    loop.clock.at_ns(35 * MS, held[0].ring)
    loop.arrive([44 * MS])
    ticks = loop.ticks(1)
    assert (times_ms(ticks), ticks[0].slot) == ([44], 2)
    ticks = loop.ticks(1)
    assert (times_ms(ticks), ticks[0].slot) == ([74], 3)


def test_messages_of_other_topics_begin_no_tick():
    loop = Loop()
    loop.arrive(range(MS, 100 * MS, MS), SCAN)
    assert times_ms(loop.ticks(3)) == [30, 50, 70]


class CountingClock(ManualClock):
    """Counts how often it is slept on."""

    sleeps = 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.sleeps += 1
        super().sleep_until_ns(deadline_ns)

    def wait_until_ns(self, deadline_ns: int, bell: Bell) -> bool:
        self.sleeps += 1
        return super().wait_until_ns(deadline_ns, bell)


@pytest.mark.parametrize("topic", [RETINA, STOP])
def test_a_flood_raises_neither_the_rate_nor_the_number_of_wake_ups(topic: Topic):
    loop = Loop()
    loop.clock = CountingClock()
    loop.pacer = InputPacer(RATE_HZ, loop.clock, loop.inbox, RETINA)
    loop.arrive(range(0, 1000 * MS, MS // 10), topic)
    ticks = loop.ticks(45)
    assert times_ms(ticks) == [10 + 20 * n for n in range(45)]
    assert loop.clock.sleeps <= 3 * len(ticks)


def test_asked_to_stop_it_does_not_tick_and_a_far_deadline_is_not_waited_for():
    assert Loop().pacer.wait(lambda: True) is None
    clock, inbox = ManualClock(), Inbox()
    pacer = InputPacer(0.1, clock, inbox, RETINA)
    assert pacer.wait(lambda: clock.time_ns >= 500 * MS) is None
    assert clock.time_ns == 600 * MS


@pytest.mark.parametrize(("topic", "leaves_out"), [(STOP, True), (RETINA, False)])
def test_what_came_too_early_makes_nobody_deaf_until_its_tick(topic: Topic, leaves_out: bool):
    clock, inbox = ManualClock(), Inbox()
    pacer = InputPacer(0.1, clock, inbox, RETINA, leaves_out=leaves_out)
    early = Message(topic.key("robot0"), b"", "", b"", 50 * MS)
    clock.at_ns(50 * MS, lambda: inbox.put(early))
    assert pacer.wait(lambda: clock.time_ns >= 500 * MS) is None
    assert 500 * MS <= clock.time_ns < 500 * MS + PATIENCE_NS
    tick = pacer.wait(NEVER)  # not asked to stop: as early as the rate allows
    assert tick is not None
    assert tick.wake_ns == 5000 * MS


def test_the_farewell_takes_what_is_left_and_does_not_wait():
    loop = Loop()
    loop.arrive([20 * MS, 21 * MS])
    loop.ticks(1)
    loop.clock.advance_to_ns(25 * MS)
    last = loop.pacer.farewell()
    assert (len(last.messages), last.slot, last.wake_ns) == (1, 1, 25 * MS)


def test_an_input_is_left_out_only_where_commands_live_for_three_periods():
    assert may_leave_one_out(SMALL)  # 50 Hz, 100 ms
    assert may_leave_one_out(replace(SMALL, rate_hz=30.0))
    assert not may_leave_one_out(replace(SMALL, rate_hz=29.0))


class Rehearsing(Loop):
    """Notes when it is rehearsed, which takes a while, and how long its last tick took."""

    def __init__(self, takes_ns: int, tick_ns: int | None = None) -> None:
        super().__init__()
        self.takes_ns, self.began_ns = takes_ns, list[int]()
        self.tick_ns: int | None = takes_ns if tick_ns is None else tick_ns
        self.pacer = InputPacer(RATE_HZ, self.clock, self.inbox, RETINA, rehearse=self)

    def __call__(self) -> None:
        self.began_ns.append(self.clock.time_ns)
        self.clock.advance_to_ns(self.clock.time_ns + self.takes_ns)


US = 1000


def test_it_is_rehearsed_shortly_before_an_input_is_expected_and_the_tick_is_as_punctual():
    loop = Rehearsing(50 * US)
    loop.arrive(range(P, 20 * P, P))
    ticks = loop.ticks(12)
    assert [tick.wake_ns for tick in ticks] == [n * P for n in range(1, 13)]
    assert [12 * P - at_ns for at_ns in loop.began_ns[-2:]] == [350 * US, 130 * US]


def test_where_no_input_was_foreseen_nothing_is_rehearsed():
    loop = Rehearsing(50 * US)
    loop.ticks(12)
    assert loop.began_ns == []


@settings(max_examples=100, deadline=None)
@given(arrivals, st.integers(0, 2 * MS))
def test_a_rehearsal_never_makes_a_tick_later_than_it_takes_itself(times: list[int], takes_ns: int):
    loop = Rehearsing(takes_ns)
    loop.arrive(times)
    ticks = loop.ticks(30)
    assert all(tick.wake_ns - tick.deadline_ns <= takes_ns for tick in ticks)
    heard = [message.received_ns for tick in ticks for message in tick.messages]
    assert heard == times[: len(heard)]
