from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.lockstep_pacer import LockstepPacer
from reflexarc_runtime.loop.pacing.pacer import Wakeup
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from support.sensing import MS, retina_message

NEVER = bool  # bool() is False


def wakeups(pacer: RatePacer, clock: ManualClock, work_ms: list[float]) -> list[Wakeup]:
    seen = []
    for work in work_ms:
        wakeup = pacer.wait(NEVER)
        assert wakeup is not None
        seen.append(wakeup)
        clock.time_ns += round(work * MS)
    return seen


def test_deadlines_are_absolute_whatever_the_work_takes():
    clock = ManualClock(5 * MS)
    pacer = RatePacer(100.0, clock, Inbox())
    seen = wakeups(pacer, clock, [1.0, 9.0, 3.0, 0.0])
    assert [w.deadline_ns // MS for w in seen] == [15, 25, 35, 45]
    assert [w.wake_ns // MS for w in seen] == [15, 25, 35, 45]


def test_oversleeping_does_not_add_up():
    clock = ManualClock(oversleep_ns=2 * MS)
    seen = wakeups(RatePacer(100.0, clock, Inbox()), clock, [0.0] * 5)
    assert [w.wake_ns // MS for w in seen] == [12, 22, 32, 42, 52]
    assert {w.wake_ns - w.deadline_ns for w in seen} == {2 * MS}


def test_missed_slots_are_skipped_and_never_caught_up_in_a_burst():
    clock = ManualClock()
    seen = wakeups(RatePacer(100.0, clock, Inbox()), clock, [0.0, 35.0, 0.0, 0.0])
    assert [w.slot for w in seen] == [1, 2, 5, 6]  # 3 and 4 passed during the work
    assert [w.wake_ns // MS for w in seen] == [10, 20, 55, 60]


def test_the_slots_begin_when_the_loop_first_waits():
    clock = ManualClock()
    pacer = RatePacer(100.0, clock, Inbox())
    clock.time_ns += 500 * MS  # a slow start between the two
    wakeup = pacer.wait(NEVER)
    assert wakeup is not None
    assert wakeup.slot == 1


def test_a_tick_drains_all_that_arrived_and_then_reads_the_time():
    clock, inbox = ManualClock(), Inbox()
    for i in range(3):
        inbox.put(retina_message(i, i))
    wakeup = RatePacer(100.0, clock, inbox).wait(NEVER)
    assert wakeup is not None
    assert len(wakeup.messages) == 3
    assert all(m.received_ns <= wakeup.now_ns for m in wakeup.messages)
    assert inbox.drain(clock.now_ns)[0] == ()


def test_asked_to_stop_it_does_not_tick():
    assert RatePacer(100.0, ManualClock(), Inbox()).wait(lambda: True) is None
    assert LockstepPacer(Inbox()).wait(lambda: True) is None


def test_a_slow_loop_is_asked_to_stop_long_before_its_deadline():
    clock = ManualClock()
    asked: list[int] = []

    def after_half_a_second() -> bool:
        asked.append(clock.time_ns)
        return clock.time_ns >= 500 * MS

    assert RatePacer(0.1, clock, Inbox()).wait(after_half_a_second) is None
    assert clock.time_ns == 600 * MS
    assert len(asked) < 10


def test_lockstep_ticks_once_an_input_on_the_input_s_own_time():
    inbox = Inbox()
    for i in (1, 2, 3):
        inbox.put(retina_message(i, received_ns=999, source_ns=i * 20 * MS))
    pacer = LockstepPacer(inbox)
    seen = [pacer.wait(NEVER) for _ in range(3)]
    assert [w.now_ns // MS for w in seen if w] == [20, 40, 60]
    assert [w.messages[0].received_ns // MS for w in seen if w] == [20, 40, 60]
    assert [w.slot for w in seen if w] == [1, 2, 3]


def test_lockstep_time_never_goes_back():
    inbox = Inbox()
    inbox.put(retina_message(1, 0, source_ns=40 * MS))
    inbox.put(retina_message(2, 0, source_ns=20 * MS))
    pacer = LockstepPacer(inbox)
    assert [w.now_ns // MS for w in (pacer.wait(NEVER), pacer.wait(NEVER)) if w] == [40, 40]


def test_a_full_inbox_loses_the_oldest_and_counts_it():
    inbox = Inbox(capacity=2)
    for i in range(5):
        inbox.put(retina_message(i, i))
    assert [m.received_ns for m in inbox.drain(lambda: 5)[0]] == [3, 4]
    assert inbox.overflows == 3


def test_taking_from_an_empty_inbox_gives_nothing_after_the_timeout():
    assert Inbox().take(0.001) is None
