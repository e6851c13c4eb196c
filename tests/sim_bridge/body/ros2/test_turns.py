from collections.abc import Callable

import pytest

from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.turns import Turns
from support.sensing import MS


class Post:
    """An inbox whose messages come at given times of a manual clock."""

    def __init__(self, clock: ManualClock, times_ms: list[float]) -> None:
        self._clock = clock
        self._times_ns = [round(time_ms * MS) for time_ms in times_ms]

    def take(self, timeout_s: float) -> Message | None:
        until_ns = self._clock.now_ns() + round(timeout_s * 1e9)
        if not self._times_ns or self._times_ns[0] > until_ns:
            self._clock.sleep_until_ns(until_ns)
            return None
        self._clock.sleep_until_ns(self._times_ns[0])
        return self._pop()

    def drain(self, now_ns: Callable[[], int]) -> tuple[tuple[Message, ...], int]:
        messages = []
        while self._times_ns and self._times_ns[0] <= now_ns():
            messages.append(self._pop())
        return tuple(messages), now_ns()

    def _pop(self) -> Message:
        return Message("robot0/command", b"", "", b"", self._times_ns.pop(0))


def turns_at(times_ms: list[float], count: int, *, speaks: bool = True) -> list[tuple[float, int]]:
    """(time in ms, messages) of the first turns of a bridge at 50 Hz."""
    clock = ManualClock()
    turns = Turns(50.0, clock, Post(clock, times_ms))
    seen = []
    for _ in range(count):
        turn = turns.wait(lambda: False)
        assert turn is not None
        if speaks or turn.is_due:
            turns.spoke(turn.now_ns)
        seen.append((turn.now_ns / MS, len(turn.messages)))
    return seen


def test_in_silence_a_turn_comes_at_once_and_then_every_period():
    assert turns_at([], 4) == [(0, 0), (20, 0), (40, 0), (60, 0)]


def test_what_arrives_is_a_turn_at_once_and_the_period_counts_from_there():
    assert turns_at([27.0], 4) == [(0, 0), (20, 0), (27, 1), (47, 0)]


def test_a_command_just_behind_a_turn_of_the_clock_does_not_wait():
    assert turns_at([20.5], 3) == [(0, 0), (20, 0), (20.5, 1)]


def test_a_flood_makes_four_turns_a_period_at_most():
    flood = [21 + number / 10 for number in range(400)]
    assert turns_at(flood, 6) == [(0, 0), (20, 0), (21, 1), (26, 50), (31, 50), (36, 50)]


def test_a_flood_that_says_nothing_does_not_delay_what_is_due():
    flood = [1 + number / 10 for number in range(1000)]
    due = [time_ms for time_ms, _ in turns_at(flood, 12, speaks=False)]
    assert due[0] == 0
    assert any(20 <= time_ms < 26 for time_ms in due)


@pytest.mark.parametrize("rate_hz", [1.0, 50.0])
def test_it_ends_within_50_ms_of_being_asked(rate_hz: float):
    clock = ManualClock()
    turns = Turns(rate_hz, clock, Post(clock, []))
    turns.spoke(0)
    assert turns.wait(lambda: clock.now_ns() > 10 * MS) is None or clock.now_ns() <= 60 * MS
    assert clock.now_ns() <= 60 * MS


def test_a_rest_takes_its_time_whatever_arrives():
    clock = ManualClock()
    turns = Turns(50.0, clock, Post(clock, [1.0, 2.0]))
    assert turns.rest(20 * MS) == 20 * MS
