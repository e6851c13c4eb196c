"""The queue between loop and recorder: a tick goes in whole and comes out message by message."""

import threading

from reflexarc_logs.recording.backlog import Backlog
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
