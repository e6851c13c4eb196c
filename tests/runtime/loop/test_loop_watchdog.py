"""The watchdog of the loop, one look at a time, on a clock that moves by itself."""

import threading
import time
from contextlib import nullcontext
from dataclasses import dataclass, field

import pytest

from reflexarc_runtime.loop import loop_watchdog
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.loop_watchdog import Budget, LoopWatchdog
from reflexarc_runtime.messages.wire import Message
from support.sensing import MS

BUDGET = Budget(tick_ns=50 * MS, period_ns=20 * MS, process_s=1.0)


@dataclass
class Said:
    """Whatever the watchdog does, in order."""

    words: list[str] = field(default_factory=list)

    def stand(self, now_ns: int) -> None:
        self.words.append("stand")

    def tell(self, since_ns: int, late_ns: int, now_ns: int) -> Message:
        self.words.append(f"late {late_ns // MS} ms")
        return Message("robot0/overrun", b"", "", b"", now_ns)

    def withdraw(self) -> None:
        self.words.append("gone")

    def renew(self) -> None:
        self.words.append("back")

    def end_decision(self) -> None:
        self.words.append("end")

    def take(self) -> list[str]:
        words, self.words = self.words, []
        return words


class Watched:
    """A watchdog whose thread does not run, and all that it talks to."""

    def __init__(self) -> None:
        self.clock, self.inbox, self.said = ManualClock(1000 * MS), Inbox(), Said()
        said = self.said
        self.dog = LoopWatchdog(
            BUDGET, self.clock.now_ns, self.inbox, said, said, said.end_decision
        )
        self.sent = 0

    def look_after(self, milliseconds: int) -> list[str]:
        self.clock.time_ns += milliseconds * MS
        self.dog.look()
        return self.said.take()

    def begin(self) -> None:
        self.dog.begin(self.clock.time_ns)

    def rest(self) -> None:
        self.dog.rest(self.clock.time_ns)

    def put(self, payload: bytes, time_ns: int) -> None:
        self.sent += 1

    def send(self, *, is_safe: bool) -> bool:
        return self.dog.let_pass(self, b"", 0, is_safe)


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> Watched:
    monkeypatch.setattr("signal.setitimer", lambda *_: None)
    return Watched()


def test_before_the_first_tick_nobody_is_late(watched: Watched):
    assert watched.look_after(10_000) == []


def test_a_tick_is_late_after_its_budget_and_not_before(watched: Watched):
    watched.begin()
    assert watched.look_after(50) == []
    assert watched.look_after(1) == ["stand", "late 51 ms", "gone", "end"]


def test_a_loop_that_does_not_wake_is_late_after_a_period_and_its_budget(watched: Watched):
    watched.begin()
    watched.rest()
    assert watched.look_after(70) == []
    assert watched.look_after(1) == ["stand", "late 51 ms", "gone", "end"]


def test_one_hang_is_one_overrun_and_the_safe_command_is_repeated(watched: Watched):
    watched.begin()
    watched.look_after(60)
    assert watched.look_after(10) == ["stand", "gone", "end"]
    messages, _ = watched.inbox.drain(watched.clock.now_ns)
    assert [message.key for message in messages] == ["robot0/overrun"]


def test_a_loop_that_is_back_is_announced_once(watched: Watched):
    watched.begin()
    watched.look_after(60)
    watched.rest()
    assert watched.look_after(10) == ["back"]
    assert watched.look_after(10) == []


def test_a_second_hang_that_follows_unseen_is_an_overrun_of_its_own(watched: Watched):
    watched.begin()
    watched.look_after(60)
    watched.begin()
    assert watched.look_after(60) == ["stand", "late 60 ms", "gone", "end"]


def test_a_driving_command_is_sent_while_nobody_spoke_in_its_place(watched: Watched):
    watched.begin()
    assert watched.send(is_safe=False)
    assert watched.sent == 1


def test_after_the_watchdog_spoke_the_next_command_is_a_safe_one(watched: Watched):
    watched.begin()
    watched.look_after(60)
    assert not watched.send(is_safe=False)
    assert not watched.send(is_safe=False)
    assert watched.send(is_safe=True)
    assert watched.send(is_safe=False)
    assert watched.sent == 2


def test_it_looks_also_where_the_time_outs_of_locks_never_end(monkeypatch: pytest.MonkeyPatch):
    """A wall clock that is set back does that to a Python that was built without sem_clockwait."""
    waits = threading.Event.wait
    monkeypatch.setattr(threading.Event, "wait", lambda event, timeout=None: waits(event))
    monkeypatch.setattr(loop_watchdog, "KernelTimer", NoTimer)
    said, patience_s = Said(), time.monotonic() + 30.0
    budget = Budget(tick_ns=4 * MS, period_ns=MS, process_s=1.0)
    with LoopWatchdog(budget, time.monotonic_ns, Inbox(), said, said, said.end_decision) as dog:
        dog.begin(time.monotonic_ns())
        while "gone" not in said.words:
            assert time.monotonic() < patience_s
            time.sleep(0.001)
        dog.rest(time.monotonic_ns() + 10**12)
        while "back" not in said.words:
            assert time.monotonic() < patience_s
            time.sleep(0.001)


@pytest.mark.parametrize("budget_s", [0.004, 4000.0])
def test_a_run_ends_soon_however_seldom_it_looks(monkeypatch: pytest.MonkeyPatch, budget_s: float):
    monkeypatch.setattr(loop_watchdog, "KernelTimer", NoTimer)
    said = Said()
    budget = Budget(round(budget_s * 1e9), MS, 1.0)
    dog = LoopWatchdog(budget, time.monotonic_ns, Inbox(), said, said, said.end_decision)
    with dog:
        pass  # a thread that slept for a quarter of it would be joined after a quarter of an hour


class NoTimer(nullcontext[None]):
    """Ends no process."""

    def wind(self, now_ns: int) -> None:
        pass
