"""Threads of this process on the kernel of this machine, where it grants a priority."""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from reflexarc_runtime.loop.realtime import Realtime, RealtimeSettings

Standing = tuple[int, int, set[int]]
"""Policy, priority, processors."""


class Parked:
    """A thread that waits until its test is over, and starts others when it is told to."""

    def __init__(self, name: str = "") -> None:
        self._begun, self._todo, self._done = (threading.Event() for _ in range(3))
        self._act: Callable[[], Any] | None = None
        self.found: Any = None
        self._thread = threading.Thread(target=self._wait, name=name or None, daemon=True)
        self._thread.start()
        assert self._begun.wait(10.0)

    def does(self, act: Callable[[], Any]) -> Any:
        """Do something in this thread; what came of it."""
        self._act = act
        self._todo.set()
        assert self._done.wait(10.0)
        self._done.clear()
        return self.found

    def end(self) -> None:
        self._act = None
        self._todo.set()
        self._thread.join()

    @property
    def standing(self) -> Standing:
        number = self._thread.native_id or 0
        scheduling = os.sched_getscheduler(number), os.sched_getparam(number).sched_priority
        return *scheduling, os.sched_getaffinity(number)

    def _wait(self) -> None:
        self._begun.set()
        while self._todo.wait() and self._act is not None:
            self._todo.clear()
            self.found = self._act()
            self._done.set()


@contextmanager
def ended(*threads: Parked) -> Iterator[None]:
    try:
        yield
    finally:
        for thread in threads:
            thread.end()


def may_use_fifo() -> bool:
    before, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(51))
        os.sched_setscheduler(0, before, priority)
    except OSError:
        return False
    return True


@pytest.mark.skipif(not may_use_fifo(), reason="SCHED_FIFO 51 is not granted here")
def test_threads_have_their_priorities_and_the_processors_of_before_and_give_all_back():
    own, usual = os.sched_getaffinity(0), (os.SCHED_OTHER, 0, os.sched_getaffinity(0))
    watchdog, recorder = Parked("watchdog"), Parked()
    with Realtime(RealtimeSettings(50, (max(own),))) as realtime:
        assert os.sched_getaffinity(0) == {max(own)}
        sensor = Parked()
        assert sensor.standing == (os.SCHED_OTHER, 0, {max(own)})
        realtime.take_in()
        syncer = recorder.does(Parked)
        assert watchdog.standing == (os.SCHED_FIFO, 51, own)
        for thread in (recorder, sensor, syncer):
            assert thread.standing == (os.SCHED_FIFO, 1, own)
    with ended(watchdog, recorder, sensor, syncer):
        for thread in (watchdog, recorder, sensor, syncer):
            assert thread.standing == usual
    assert (os.sched_getscheduler(0), os.sched_getaffinity(0)) == (os.SCHED_OTHER, own)
