import os
import threading
import time
from collections.abc import Callable

import pytest

from reflexarc_runtime.loop.bell import Bell, EventBell, LockBell, locks_wait_steadily, new_bell

either = pytest.mark.parametrize("made", [LockBell, EventBell])
Made = Callable[[], Bell]


@either
def test_a_ring_before_anybody_listens_is_heard_once(made: Made):
    bell = made()
    bell.ring()
    bell.ring()
    assert bell.heard(0.0)
    assert not bell.heard(0.0)


@either
def test_a_silent_bell_is_waited_for_no_longer_than_asked(made: Made):
    assert not made().heard(0.001)
    assert not made().heard(-1.0)


@either
def test_a_hushed_bell_was_never_rung(made: Made):
    bell = made()
    bell.ring()
    bell.hush()
    bell.hush()
    assert not bell.heard(0.0)


@either
def test_whoever_waits_is_woken_from_another_thread(made: Made):
    bell = made()
    ringing = threading.Timer(0.01, bell.ring)
    ringing.start()
    assert bell.heard(60.0)
    ringing.join()


@either
def test_many_threads_that_ring_at_once_are_no_error(made: Made):
    bell, failures = made(), []

    def ring() -> None:
        try:
            for _ in range(2000):
                bell.ring()
                bell.hush()
        except RuntimeError as error:
            failures.append(error)

    threads = [threading.Thread(target=ring) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []


@either
def test_a_wait_without_a_ring_is_no_shorter_than_asked(made: Made):
    bell, began_ns = made(), time.monotonic_ns()
    assert not bell.heard(0.02)
    assert time.monotonic_ns() - began_ns >= 20_000_000


def test_a_python_whose_locks_follow_the_wall_clock_has_another_bell(
    monkeypatch: pytest.MonkeyPatch,
):
    for value, kind in ((1, LockBell), (0, EventBell), (None, EventBell)):
        monkeypatch.setattr("sysconfig.get_config_var", lambda name, value=value: value)
        locks_wait_steadily.cache_clear()
        assert type(new_bell()) is kind
    monkeypatch.setattr("sys.platform", "darwin")
    locks_wait_steadily.cache_clear()
    assert type(new_bell()) is LockBell
    monkeypatch.undo()
    locks_wait_steadily.cache_clear()


def test_a_bell_that_nobody_has_any_more_gives_its_descriptor_back():
    before = len(os.listdir("/proc/self/fd"))
    bells = [EventBell() for _ in range(20)]
    assert len(os.listdir("/proc/self/fd")) == before + 20
    bells.clear()
    assert len(os.listdir("/proc/self/fd")) == before
