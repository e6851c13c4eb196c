"""What is rehearsed when, by a clock that moves only when it is slept on."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import NoOutlet, Outlets
from reflexarc_runtime.loop.pacing.occasions import RehearsingClock
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.loop.rehearsal import Rehearsal
from reflexarc_runtime.messages_pb2 import Command
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, ScriptedPolicy, exported
from support.recordings import CONTRACT, PERIOD_NS, START_NS, nominal

MS, US = 1_000_000, 1_000
RETINAS = [message for messages in nominal(60).values() for message in messages]


class Kept:
    """An outlet that remembers."""

    def __init__(self) -> None:
        self.payloads: list[bytes] = []

    def put(self, payload: bytes, time_ns: int) -> None:
        self.payloads.append(payload)


class Slow:
    """A rehearsal that takes a while, and notes when it began."""

    def __init__(self, clock: ManualClock, takes_ns: int, tick_ns: int | None = 50 * US) -> None:
        self.clock, self.takes_ns, self.tick_ns = clock, takes_ns, tick_ns
        self.began_ns: list[int] = []

    def __call__(self) -> None:
        self.began_ns.append(self.clock.time_ns)
        self.clock.time_ns += self.takes_ns


def began_before(period_ns: int, takes_ns: int, periods: int = 40) -> tuple[list[int], int]:
    """How long before its deadline each rehearsal began, of the last period; how late the clock."""
    clock = ManualClock()
    slow = Slow(clock, takes_ns)
    rehearsing = RehearsingClock(clock, slow)
    late_ns = 0
    for period in range(1, periods + 1):
        slow.began_ns.clear()
        rehearsing.sleep_until_ns(period * period_ns)
        late_ns = max(late_ns, clock.time_ns - period * period_ns)
    return [periods * period_ns - at_ns for at_ns in slow.began_ns], late_ns


def test_at_50_hz_it_is_rehearsed_in_good_time_and_shortly_before():
    assert began_before(20 * MS, 50 * US) == ([350 * US, 130 * US], 0)


def test_at_1_khz_it_is_rehearsed_once():
    assert began_before(MS, 50 * US) == ([130 * US], 0)


def test_a_rehearsal_that_takes_long_though_its_tick_did_not_is_hardly_ever_done():
    clock = ManualClock()
    slow = Slow(clock, 5 * MS)
    rehearsing = RehearsingClock(clock, slow)
    for period in range(1, 201):
        rehearsing.sleep_until_ns(period * 20 * MS)
    assert len(slow.began_ns) == 4  # both turns, once and once again


@pytest.mark.parametrize("takes_ns", [350 * US, 650 * US, 2 * MS, 15 * MS])
def test_the_first_rehearsals_make_no_tick_late_however_slow_its_policy_is(takes_ns: int):
    """A tick at 50 Hz has taken as long, and the loop sleeps for the rest."""
    clock = ManualClock(20 * MS)
    slow = Slow(clock, takes_ns, tick_ns=None)
    rehearsing = RehearsingClock(clock, slow)
    for deadline_ns in range(20 * MS, 2000 * MS, 20 * MS):
        rehearsing.sleep_until_ns(deadline_ns)
        assert clock.time_ns == deadline_ns
        clock.time_ns += takes_ns  # the tick
        slow.tick_ns = takes_ns
    most_ns = min(MS, 0.3 * (20 * MS - takes_ns))
    assert bool(slow.began_ns) == (takes_ns <= most_ns)


def test_a_slower_policy_that_takes_over_is_not_rehearsed_too_late():
    clock = ManualClock()
    slow = Slow(clock, 50 * US)
    rehearsing = RehearsingClock(clock, slow)
    for period in range(1, 21):
        if period == 11:
            slow.takes_ns = slow.tick_ns = 900 * US
        rehearsing.sleep_until_ns(period * 20 * MS)
        assert clock.time_ns == period * 20 * MS
    assert slow.began_ns[-1] == 400 * MS - 980 * US


def test_a_deadline_that_has_passed_is_not_rehearsed_for():
    clock = ManualClock(5 * MS)
    slow = Slow(clock, 50 * US)
    RehearsingClock(clock, slow).sleep_until_ns(5 * MS)
    assert (slow.began_ns, clock.time_ns) == ([], 5 * MS)


def test_where_the_clock_overslept_the_tick_goes_before():
    clock = ManualClock(0, oversleep_ns=200 * US)
    slow = Slow(clock, 50 * US)
    RehearsingClock(clock, slow).sleep_until_ns(20 * MS)
    assert slow.began_ns == []


class Ended(ScriptedPolicy):
    """Is ended by the watchdog whenever it is asked."""

    def decide(self, retinas):
        raise DecisionEndedError


def test_a_decision_that_the_watchdog_ends_ends_nothing_else():
    rehearsal = Rehearsal(Controller(Ended(), SMALL, RetinaSense(SMALL.retina)))
    rehearsal()
    frame = np.zeros(SMALL.retina.shape, np.uint8)
    rehearsal.note(State(streak=9, frames=(frame,)), Inputs((), 1), 0, 0)
    rehearsal()


class Feeding(ManualClock):
    """Puts a retina into the inbox whenever a period has passed."""

    def __init__(self, inbox: Inbox) -> None:
        super().__init__()
        self.inbox, self.sent = inbox, 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        super().sleep_until_ns(deadline_ns)
        while self.sent * PERIOD_NS <= self.time_ns - START_NS:
            self.sent += 1
            self.inbox.put(replace(RETINAS[self.sent], received_ns=self.time_ns))


def sent_by(rehearses: bool) -> list[bytes]:
    """All commands and ticks of a loop, by its own clock alone."""
    policy, inbox = load_policy(exported(CONTRACT)), Inbox()
    sense = RetinaSense(CONTRACT.retina)
    controller = Controller(policy, CONTRACT, sense, policy.policy_hash)
    rehearsal, clock = Rehearsal(controller), Feeding(inbox)
    clock.time_ns = START_NS
    command, tick = Kept(), Kept()
    pacer = RatePacer(50.0, RehearsingClock(clock, rehearsal) if rehearses else clock, inbox)
    outlets = Outlets(command, tick, NoOutlet())
    note = rehearsal.note if rehearses else lambda before, inputs, now_ns, decide_ns: None
    Node(controller, pacer, outlets, made_of=note).run(max_ticks=40)
    return command.payloads + tick.payloads


def test_a_loop_that_rehearses_sends_the_same_bytes():
    plain = sent_by(rehearses=False)
    assert sent_by(rehearses=True) == plain
    assert len({Command.FromString(sent).action for sent in plain[:41]}) > 1
