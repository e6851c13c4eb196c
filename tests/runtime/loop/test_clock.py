import threading
import time

from reflexarc_runtime.loop.bell import new_bell
from reflexarc_runtime.loop.clock import ManualClock, MonotonicClock


def test_what_is_to_happen_happens_in_its_order_and_shows_its_time():
    clock, seen = ManualClock(), list[tuple[str, int]]()
    for name, at_ns in (("late", 30), ("early", 10), ("second", 20), ("second too", 20)):
        clock.at_ns(at_ns, lambda name=name: seen.append((name, clock.now_ns())))  # type: ignore[misc]
    clock.sleep_until_ns(25)
    assert seen == [("early", 10), ("second", 20), ("second too", 20)]
    assert clock.now_ns() == 25
    clock.sleep_until_ns(30)
    assert seen[-1] == ("late", 30)


def test_a_bell_ends_the_wait_at_its_ring():
    clock, bell = ManualClock(oversleep_ns=3), new_bell()
    clock.at_ns(10, bell.ring)
    assert clock.wait_until_ns(50, bell)
    assert clock.now_ns() == 13
    assert not clock.wait_until_ns(50, bell)
    assert clock.now_ns() == 53


def test_a_ring_that_comes_while_it_oversleeps_is_not_lost():
    clock, bell = ManualClock(oversleep_ns=10), new_bell()
    clock.at_ns(55, bell.ring)
    assert not clock.wait_until_ns(50, bell)
    assert bell.heard(0.0)


def test_the_machine_s_clock_never_wakes_before_a_deadline_whether_it_spins_or_not():
    for spin_ns in (0, 200_000):
        clock, bell = MonotonicClock(spin_ns), new_bell()
        for _ in range(20):
            deadline_ns = time.monotonic_ns() + 300_000
            clock.sleep_until_ns(deadline_ns)
            assert time.monotonic_ns() >= deadline_ns
            deadline_ns = time.monotonic_ns() + 300_000
            assert not clock.wait_until_ns(deadline_ns, bell)
            assert time.monotonic_ns() >= deadline_ns


def test_it_returns_at_once_at_a_ring_or_a_deadline_that_has_passed():
    for spin_ns in (0, 200_000):
        clock, bell = MonotonicClock(spin_ns), new_bell()
        bell.ring()
        assert clock.wait_until_ns(time.monotonic_ns() + 10**12, bell)
        assert not clock.wait_until_ns(0, bell)
        clock.sleep_until_ns(0)


def test_it_is_rung_while_it_spins():
    clock, bell = MonotonicClock(spin_ns=10**12), new_bell()
    deadline_ns = time.monotonic_ns() + 10**12

    threading.Timer(0.01, bell.ring).start()
    assert clock.wait_until_ns(deadline_ns, bell)
