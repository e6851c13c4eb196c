import logging
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.loop import inbox as inboxes
from reflexarc_runtime.loop.bell import Bell, LockBell, new_bell
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.notices.flood_notice import FloodNotice
from reflexarc_runtime.messages.topics import COMMAND, OVERRUN, RESET, RETINA, STOP, Topic
from reflexarc_runtime.messages.wire import Message


def message(topic: Topic, number: int = 0, size: int = 0) -> Message:
    return Message(topic.key("robot0"), bytes(size), str(number), b"", number)


def drained(inbox: Inbox) -> tuple[Message, ...]:
    return inbox.drain(lambda: 10**9)[0]


def test_a_flood_of_inputs_does_not_push_a_stop_out():
    inbox = Inbox(capacity=8)
    inbox.put(message(STOP))
    for number in range(100):
        inbox.put(message(RETINA, number))
    kept = drained(inbox)
    assert [m.key for m in kept] == ["robot0/stop"] + 7 * ["robot0/retina"]
    assert [m.encoding for m in kept[1:]] == [str(n) for n in range(93, 100)]  # the newest
    assert inbox.overflows == 93


def test_a_flood_of_stops_leaves_the_newest():
    inbox = Inbox(capacity=8)
    for number in range(20):
        inbox.put(message(STOP, number))
    assert [m.encoding for m in drained(inbox)] == [str(n) for n in range(12, 20)]


def test_its_bytes_are_bounded_and_free_again_when_they_are_taken():
    inbox = Inbox(capacity_bytes=1000)
    for _ in range(2):
        for number in range(50):
            inbox.put(message(COMMAND, number, 300))
        assert sum(len(m.payload) for m in drained(inbox)) == 900
    assert inbox.overflows == 94
    for number in range(3):
        inbox.put(message(COMMAND, number, 300))
        assert inbox.take(0.0) is not None
    inbox.put(message(COMMAND, 1, 1000))
    assert len(drained(inbox)) == 1


def test_a_flood_is_said_once_and_again_only_when_it_goes_on(caplog: pytest.LogCaptureFixture):
    notice = FloodNotice("the body of robot0")
    with caplog.at_level(logging.WARNING):
        for overflows in (0, 5, 5, 9):
            notice.look(overflows)
    assert [record.getMessage() for record in caplog.records] == [
        "the body of robot0: flooded: 5 messages dropped since the last notice, 5 in all",
        "the body of robot0: flooded: 4 messages dropped since the last notice, 9 in all",
    ]


@given(st.lists(st.sampled_from("rsRo"), max_size=60), st.integers(1, 12), st.booleans())
def test_a_full_inbox_keeps_what_a_slow_list_would(kinds: list[str], capacity: int, one: bool):
    """The oldest input goes first, then the oldest reset, then the oldest of the others."""
    topics = {"r": RETINA, "s": STOP, "R": RESET, "o": OVERRUN}
    inbox, kept = Inbox(capacity), []
    for number, kind in enumerate(kinds):
        message = Message(topics[kind].key("robot0"), b"", "", b"", number)
        inbox.put(message)
        kept.append((kind, message))
        if len(kept) > capacity:
            order = [next((i for i, (k, _) in enumerate(kept) if k in few), None) for few in "rR"]
            del kept[next((place for place in order if place is not None), 0)]
    if one and kept:
        assert inbox.take(0.0) == kept.pop(0)[1]
    assert list(inbox.drain(lambda: 0)[0]) == [message for _, message in kept]


def belled() -> tuple[Inbox, Bell]:
    inbox, bell = Inbox(), new_bell()
    inbox.ring_for(RETINA, bell)
    return inbox, bell


def test_its_bell_is_rung_by_the_first_input_from_a_time_on():
    inbox, bell = belled()
    inbox.arm(10)
    inbox.put(message(RETINA, 9))
    inbox.put(message(COMMAND, 11))
    assert not bell.heard(0.0)
    inbox.put(message(RETINA, 12))
    inbox.put(message(RETINA, 13))
    assert bell.heard(0.0)
    assert not bell.heard(0.0)
    assert inbox.rung_ns == 12


def test_a_bell_that_is_armed_late_is_rung_for_what_is_there():
    inbox, bell = belled()
    for number in (5, 15, 25):
        inbox.put(message(RETINA, number))
    inbox.arm(10)
    assert bell.heard(0.0)
    assert inbox.rung_ns == 15
    drained(inbox)
    inbox.arm(20)
    assert not bell.heard(0.0)


@pytest.mark.parametrize("topic", [STOP, RESET, OVERRUN])
def test_what_stops_a_loop_rings_whenever_it_came(topic: Topic):
    inbox, bell = belled()
    inbox.put(message(topic, 1))
    inbox.arm(10)
    assert bell.heard(0.0)
    drained(inbox)
    inbox.arm(2 * 10**9)
    inbox.put(message(topic, 2))
    assert bell.heard(0.0)


def test_a_ring_for_what_was_drained_is_forgotten():
    inbox, bell = belled()
    inbox.arm(0)
    inbox.put(message(RETINA, 1))
    drained(inbox)
    inbox.arm(0)
    assert not bell.heard(0.0)


def test_whoever_takes_is_woken_by_the_first_message_and_gets_all_in_order():
    inbox, taken = Inbox(), list[str]()

    def take() -> None:
        while len(taken) < 200:
            found = inbox.take(60.0)
            assert found is not None
            taken.append(found.encoding)

    taking = threading.Thread(target=take)
    taking.start()
    for number in range(200):
        inbox.put(message(COMMAND, number))
        if number % 20 == 0:
            time.sleep(0.001)
    taking.join(60.0)
    assert taken == [str(n) for n in range(200)]


def test_a_ring_for_a_message_that_was_taken_wakes_nobody(monkeypatch: pytest.MonkeyPatch):
    inbox, taken, waits = Inbox(), list[Message | None](), threading.Event()
    bells, heard = list[Bell](), LockBell.heard

    def waiting(bell: LockBell, timeout_s: float) -> bool:
        bells.append(bell)
        waits.set()
        return heard(bell, timeout_s)

    monkeypatch.setattr(LockBell, "heard", waiting)
    monkeypatch.setattr(inboxes, "new_bell", LockBell)
    taking = threading.Thread(target=lambda: taken.append(inbox.take(60.0)))
    taking.start()
    assert waits.wait(60.0)
    waits.clear()
    bells[0].ring()
    assert waits.wait(60.0)  # again
    inbox.put(message(COMMAND, 7))
    taking.join(60.0)
    assert [found and found.encoding for found in taken] == ["7"]
