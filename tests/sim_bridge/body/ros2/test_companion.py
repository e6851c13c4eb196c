import json
import os
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.ros2.companion import FAREWELL, Companion, Pipe, Watched
from reflexarc_sim_bridge.body.ros2.messages import encode_twist
from support.gates import BODY, OTHER
from support.ros2 import moving_odometry
from support.sensing import MS
from support.spoken import FakeBus

GO = Motion(1.0)
WATCHED = Watched("robot0", 7447, "", "cmd_vel", False, BODY.hex(), 20 * MS)

Event = tuple[float, Callable[[], bytes | None]]


class Play:
    """A bridge on a manual clock: at given times it says a twist, a farewell, or ends.

    Args:
        oversleeps_ms: how much later than asked its companion is woken.
        every: at the first, and then at every so-manieth waiting.
    """

    def __init__(self, oversleeps_ms: float = 0.0, every: int = 1) -> None:
        self.clock = ManualClock()
        bus: Any = FakeBus()
        self.companion = Companion(bus, WATCHED, self.clock.now_ns)
        self._said = bus.publishers["cmd_vel"]
        self._events: list[Event] = []
        self._oversleeps_ms, self._every = oversleeps_ms, every
        self._waited = 0
        self.spoken_ms: list[float] = []

    def twist(self, time_ms: float, motion: Motion = GO, sender: bytes = BODY) -> "Play":
        attachment = pack_stamp(Stamp(0, 0, sender)) if sender else b""

        def say() -> None:
            now_ns = self.clock.now_ns()
            payload = encode_twist(motion)
            self.companion.hear(Message("cmd_vel", payload, "", attachment, now_ns))

        self._events.append((time_ms, say))
        return self

    def twists(self, first_ms: int, last_ms: int, **how: Any) -> "Play":
        for time_ms in range(first_ms, last_ms + 1, 20):
            self.twist(time_ms, **how)
        return self

    def odometry(self, first_ms: int, last_ms: int, linear_mps: float = 0.0) -> "Play":
        payload = moving_odometry(linear_mps)

        def say() -> None:
            self.companion.feel(Message("odom", payload, "", b"", self.clock.now_ns()))

        self._events += [(time_ms, say) for time_ms in range(first_ms, last_ms + 1, 20)]
        return self

    def door(self, time_ms: float, said: bytes) -> "Play":
        self._events.append((time_ms, lambda: said))
        return self

    def run(self, until_ms: float) -> list[float]:
        """When it told the robot to stand, ms."""
        self._events.sort(key=lambda event: event[0])
        self.door(until_ms, FAREWELL)
        self.companion.watch(self)
        return self.spoken_ms

    def wait(self, until_ns: int) -> bytes | None:
        self._note()
        while self._events and self._events[0][0] * MS <= until_ns:
            time_ms, act = self._events.pop(0)
            self.clock.sleep_until_ns(round(time_ms * MS))
            said = act()
            if said is not None:
                return said
        late_ms = 0.0 if self._waited % self._every else self._oversleeps_ms
        self._waited += 1
        self.clock.sleep_until_ns(until_ns + round(late_ms * MS))
        return None

    def _note(self) -> None:
        if self.companion.standstills > len(self.spoken_ms):
            self.spoken_ms.append(self.clock.now_ns() / MS)


def test_while_the_bridge_speaks_its_companion_is_silent():
    assert Play().twists(0, 2000).run(2010) == []


def test_a_bridge_that_stops_is_spoken_for_after_two_periods_for_two_seconds():
    spoken_ms = Play().twists(0, 1000).run(5000)
    assert 1040 <= spoken_ms[0] <= 1060
    assert 2980 <= spoken_ms[-1] < 3000
    assert all(18 < after - before < 22 for before, after in pairwise(spoken_ms))


def test_a_bridge_that_is_gone_is_spoken_for_at_once_and_then_the_companion_ends():
    play = Play().twists(0, 1000).door(1003, b"")
    spoken_ms = play.run(60_000)
    assert spoken_ms[0] == 1003
    assert 2980 <= spoken_ms[-1] < 3000
    assert play.clock.now_ns() < 3100 * MS


def test_a_bridge_that_is_gone_before_it_drove_needs_no_word():
    play = Play().twists(0, 1000, motion=STANDSTILL).door(1003, b"")
    assert play.run(60_000) == []
    assert play.clock.now_ns() < 1100 * MS


def test_a_robot_whose_odometry_says_that_it_stands_needs_no_more_words():
    play = Play().twists(0, 1000).odometry(0, 1490, 1.0).odometry(1500, 5000)
    spoken_ms = play.run(5000)
    assert 1040 <= spoken_ms[0] <= 1060
    assert 1700 <= spoken_ms[-1] <= 1740


def test_a_robot_that_a_person_drives_away_is_left_alone():
    play = Play().twists(0, 1000).odometry(0, 1300).odometry(1320, 1900).odometry(1920, 5000, 1.0)
    assert play.run(5000)[-1] <= 1540


def test_an_odometry_that_lies_makes_it_no_shorter_than_half_a_second():
    play = Play().twists(0, 1000).odometry(0, 60_000).door(1003, b"")
    spoken_ms = play.run(60_000)
    assert 1500 <= spoken_ms[-1] <= 1540
    assert play.clock.now_ns() < 1600 * MS


@pytest.mark.parametrize("last_ms", [0, 1400])
def test_an_odometry_that_moves_for_ever_or_is_absent_makes_it_no_longer(last_ms: int):
    play = Play().twists(0, 1000).odometry(0, last_ms, 1.0)
    assert 2980 <= play.run(5000)[-1] < 3000


def test_a_bridge_that_drives_a_robot_that_stands_is_watched_all_the_same():
    play = Play().twists(0, 1000).odometry(0, 5000)  # against a wall
    assert 1040 <= play.run(5000)[0] <= 1060


def test_a_farewell_ends_it_without_a_word():
    play = Play().twists(0, 1000).door(1003, FAREWELL)
    assert play.run(60_000) == []
    assert play.clock.now_ns() < 1100 * MS


def test_a_bridge_that_goes_on_is_not_spoken_for_any_more():
    spoken_ms = Play().twists(0, 1000).twists(1200, 2000).run(2010)
    assert spoken_ms
    assert all(1040 <= time_ms <= 1200 for time_ms in spoken_ms)


def test_twists_of_others_are_no_sign_of_the_bridge_s_life():
    play = Play().twists(0, 1000)
    play.twists(1010, 3000, sender=OTHER).twists(1010, 3000, sender=b"")
    assert 1040 <= play.run(5000)[0] <= 1060


def test_others_alone_are_none_of_its_business():
    assert Play().twists(0, 1000, sender=OTHER).run(3000) == []


def test_who_overslept_first_listens_to_what_was_said_meanwhile():
    assert Play(oversleeps_ms=200.0, every=2).twists(0, 3000).run(3001) == []


@pytest.mark.parametrize("every", [1, 2, 3])
def test_an_oversleep_delays_its_word_by_no_more_than_itself_and_a_quarter_period(every: int):
    spoken_ms = Play(oversleeps_ms=30.0, every=every).twists(0, 1000).run(5000)
    woken_twice_ms = 30.0 if every == 1 else 0.0
    assert spoken_ms[0] <= 1000 + 40 + 30 + 5 + woken_twice_ms


def test_one_that_is_always_woken_too_late_speaks_nevertheless():
    spoken_ms = Play(oversleeps_ms=200.0).twists(0, 1000).run(5000)
    assert len(spoken_ms) > 3


def test_the_pipe_tells_nothing_from_a_word_and_from_its_end():
    out, into = os.pipe()
    pipe = Pipe(out)
    assert pipe.wait(0) is None
    os.write(into, FAREWELL)
    assert pipe.wait(0) == FAREWELL
    os.close(into)
    assert pipe.wait(0) == b""
    assert pipe.wait(0) is None
    os.close(out)


def test_what_it_is_told_on_its_command_line_comes_back():
    assert fill(Watched, MappingSource(json.loads(WATCHED.text()))) == WATCHED
