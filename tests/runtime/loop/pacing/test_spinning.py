"""How long a loop looks at the clock before its ticks, on a machine that oversleeps."""

import heapq
from collections.abc import Callable
from itertools import count

import pytest

from reflexarc_runtime.loop import clock as clocks
from reflexarc_runtime.loop.bell import LockBell
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing import input_pacer
from reflexarc_runtime.loop.pacing.input_pacer import InputPacer
from reflexarc_runtime.loop.pacing.occasions import RehearsingClock
from reflexarc_runtime.loop.pacing.pacer import Pacer
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.topics import RETINA, STOP, Topic
from reflexarc_runtime.messages.wire import Message
from support.sensing import MS

US = 1000
LOOK_NS = US // 2
REHEARSAL_NS = 50 * US
NEVER = bool  # bool() is False
really_heard = LockBell.heard


class Machine:
    """Its clock, its sleep, and what happens when; in place of `time` and of a bell's wait."""

    def __init__(self, oversleep_ns: int = 0) -> None:
        self.now_ns, self.oversleep_ns = 0, oversleep_ns
        self.spun_ns = self.rehearsed = 0
        self.tick_ns: int | None = REHEARSAL_NS
        self._to_come: list[tuple[int, int, Callable[[], None]]] = []
        self._order = count()

    def monotonic_ns(self) -> int:
        return self.now_ns

    def sleep(self, seconds: float) -> None:
        if seconds > 0.0:
            self.advance(round(seconds * 1e9) + self.oversleep_ns)
        else:
            self.spun_ns += LOOK_NS
            self.advance(LOOK_NS)

    def advance(self, by_ns: int) -> None:
        end_ns = self.now_ns + by_ns
        while self._to_come and self._to_come[0][0] <= end_ns:
            self.now_ns, _, act = heapq.heappop(self._to_come)
            act()
        self.now_ns = end_ns

    def arrives(self, at_ns: int, inbox: Inbox, topic: Topic = RETINA) -> None:
        message = Message(topic.key("robot0"), b"", "", b"", at_ns)
        heapq.heappush(self._to_come, (at_ns, next(self._order), lambda: inbox.put(message)))

    def hears(self, bell: LockBell, timeout_s: float) -> bool:
        end_ns = self.now_ns + round(timeout_s * 1e9)
        while not (is_rung := really_heard(bell, 0.0)) and self.now_ns < end_ns:
            next_ns = self._to_come[0][0] if self._to_come else end_ns
            at_ns = next_ns if next_ns < end_ns else end_ns + self.oversleep_ns
            self.advance(at_ns - self.now_ns)
        return is_rung

    def __call__(self) -> None:
        """A rehearsal."""
        self.rehearsed += 1
        self.advance(REHEARSAL_NS)


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    made = Machine()
    monkeypatch.setattr(clocks, "time", made)
    monkeypatch.setattr(input_pacer, "new_bell", LockBell)
    monkeypatch.setattr(LockBell, "heard", lambda bell, timeout_s: made.hears(bell, timeout_s))
    return made


def late(machine: Machine, pacer: Pacer, ticks: int) -> list[int]:
    """By how much each of them was late; none takes time."""
    wakeups = [pacer.wait(NEVER) for _ in range(ticks)]
    return [each.wake_ns - each.deadline_ns for each in wakeups if each is not None]


rates = pytest.mark.parametrize("rate_hz", [1000.0, 50.0, 1.0, 0.1])
spins = pytest.mark.parametrize("spin_us", [0, 20, 100, 400, 900])


@rates
@spins
def test_at_a_rate_it_spins_so_long_and_no_longer_and_rehearses_as_without(
    machine: Machine, rate_hz: float, spin_us: int
):
    clock = RehearsingClock(MonotonicClock(spin_us * US), machine)
    late_ns = late(machine, RatePacer(rate_hz, clock, Inbox()), 10)
    assert max(late_ns) <= LOOK_NS
    occasions = 1 if rate_hz == 1000.0 else 2
    assert machine.rehearsed == occasions * 10
    longest_ns = spin_us * US + occasions * LOOK_NS + LOOK_NS
    assert machine.spun_ns <= 10 * longest_ns
    if spin_us:  # all of it but for what is rehearsed meanwhile
        assert machine.spun_ns >= 10 * (min(spin_us * US, 80 * US) - LOOK_NS)


@rates
def test_who_spins_for_longer_than_a_machine_oversleeps_is_never_late(
    machine: Machine, rate_hz: float
):
    machine.oversleep_ns = 150 * US
    clock = RehearsingClock(MonotonicClock(200 * US), machine)
    assert max(late(machine, RatePacer(rate_hz, clock, Inbox()), 10)) <= LOOK_NS


@rates
@spins
def test_at_an_input_it_spins_for_deadlines_alone(machine: Machine, rate_hz: float, spin_us: int):
    inbox, period_ns = Inbox(), round(1e9 / rate_hz)
    clock = MonotonicClock(spin_us * US)
    pacer = InputPacer(rate_hz, clock, inbox, RETINA, rehearse=machine)
    for n in range(1, 21):
        machine.arrives(n * period_ns, inbox)
    if spin_us * US < period_ns // 2:  # else it always looks
        assert set(late(machine, pacer, 20)) == {0}
        assert machine.spun_ns == 0
        assert machine.rehearsed >= 15
    else:
        late(machine, pacer, 20)
    machine.spun_ns = 0
    assert max(late(machine, pacer, 10)) <= LOOK_NS  # silence
    assert machine.spun_ns <= 10 * (spin_us * US + 3 * LOOK_NS)


def test_what_came_too_early_is_spun_for_when_its_tick_is_due(machine: Machine):
    inbox = Inbox()
    machine.oversleep_ns = 150 * US
    machine.arrives(50 * MS, inbox, STOP)
    pacer = InputPacer(1.0, MonotonicClock(200 * US), inbox, RETINA)
    assert late(machine, pacer, 1)[0] <= LOOK_NS
    assert 0 < machine.spun_ns <= 201 * US
    assert 500 * MS <= machine.now_ns <= 501 * MS
