"""The queue between loop and recorder: a tick goes in whole and comes out message by message."""

import threading

from reflexarc_logs.recording.backlog import MOST_NAP_NS, Backlog
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.tick_record import LoopIdentity, TickRecord
from reflexarc_runtime.messages.wire import Message

LOOP = LoopIdentity("robot0", b"s" * 16)
HEARD = Message("robot0/retina", bytes(10), "e", b"", 1)
OTHER = Message("robot0/pose", bytes(7), "e", b"", 2)
TICK = TickRecord((HEARD, HEARD), b"t" * 5, b"c" * 3, 0, 1, LOOP)
"""Four records of 28 bytes."""


def test_a_tick_comes_out_in_order_between_its_neighbours():
    backlog = Backlog()
    backlog.put(OTHER)
    backlog.put_tick(TICK)
    backlog.put(OTHER)
    backlog.end()
    taken = []
    while (entry := backlog.take(0.0)) is not None:
        taken.append(entry)
        assert backlog.waiting == 6 - len(taken)
    assert taken == [OTHER, *TICK.messages(), OTHER]
    assert backlog.ended


def test_a_tick_for_which_there_is_no_room_is_dropped_whole_and_each_record_counted():
    few, small = Backlog(max_records=7), Backlog(max_bytes=55)
    for backlog in (few, small):
        for _ in range(2):
            backlog.put_tick(TICK)
        assert (backlog.waiting, backlog.dropped) == (4, 4)
        backlog.take(0.0)
        backlog.put_tick(TICK)  # one less waits: 3 + 4 records, 18 + 28 bytes
        assert (backlog.waiting, backlog.dropped) == (7, 4)


def test_many_threads_put_and_nothing_is_lost_or_counted_twice():
    backlog = Backlog()

    def put_many() -> None:
        for _ in range(2000):
            backlog.put(OTHER)

    others = [threading.Thread(target=put_many) for _ in range(2)]
    for thread in others:
        thread.start()
    for _ in range(2000):
        backlog.put_tick(TICK)
    for thread in others:
        thread.join()
    assert (backlog.waiting, backlog.dropped) == (4 * 2000 + 2 * 2000, 0)
    while backlog.waiting:
        assert backlog.take(0.0) is not None
    assert backlog.take(0.0) is None


MS = 1_000_000


def taken_at(period_ns: int, ticks: int) -> tuple[list[int], int]:
    """How long after its beginning each tick was taken, on a clock of its own; and the looks."""
    clock, ages_ns = CountingClock(), []
    backlog = Backlog(clock=clock)
    for n in range(1, ticks + 1):
        tick = TickRecord((), b"t", None, n, n * period_ns, LOOP)
        clock.at_ns(n * period_ns, lambda tick=tick: backlog.put_tick(tick))  # type: ignore[misc]
    for n in range(1, ticks + 1):
        assert backlog.take(60.0) is not None
        ages_ns.append(clock.time_ns - n * period_ns)
    return ages_ns, clock.sleeps


class CountingClock(ManualClock):
    """Counts how often it is slept on."""

    sleeps = 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.sleeps += 1
        super().sleep_until_ns(deadline_ns)


def test_ticks_are_taken_a_quarter_of_a_period_after_they_began():
    for period_ns in (2 * MS, 10 * MS, 16 * MS):
        ages_ns, looks = taken_at(period_ns, 100)
        assert set(ages_ns[50:]) == {period_ns // 4}
        assert looks < 130


def test_slow_ticks_are_looked_for_at_least_every_so_often():
    ages_ns, looks = taken_at(100 * MS, 20)
    assert max(ages_ns) <= MOST_NAP_NS
    assert looks < 8 * 20


def test_what_has_no_rhythm_waits_no_longer_and_nobody_looks_all_the_time():
    clock = CountingClock()
    backlog = Backlog(clock=clock)
    clock.at_ns(3 * MS, lambda: backlog.put(OTHER))
    assert backlog.take(1.0) is OTHER
    assert clock.time_ns <= 3 * MS + MOST_NAP_NS
    assert backlog.take(0.5) is None
    assert clock.sleeps <= 2 + 520 // 20
    assert clock.time_ns <= 3 * MS + MOST_NAP_NS + 500 * MS


def test_what_was_put_before_the_end_is_taken_before_it():
    backlog = Backlog(clock=ManualClock())
    backlog.put(OTHER)
    backlog.end()
    assert (backlog.take(1.0), backlog.ended) == (OTHER, False)
    assert (backlog.take(1.0), backlog.ended) == (None, True)
