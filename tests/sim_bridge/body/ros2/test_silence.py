import pytest

from reflexarc_sim_bridge.body.ros2.silence import HELD_NS, BridgeSilence
from support.sensing import MS

PERIOD_NS = 20 * MS
NEW = BridgeSilence(PERIOD_NS)
DRIVING = NEW.heard(100 * MS, moves=True)


def test_a_bridge_that_never_spoke_is_not_spoken_for():
    assert not NEW.must_speak(10**12, is_gone=False)
    assert not NEW.must_speak(10**12, is_gone=True)


@pytest.mark.parametrize(("now_ms", "speaks"), [(101, False), (139, False), (140, True)])
def test_two_periods_without_a_twist_are_a_silence(now_ms: int, speaks: bool):
    assert DRIVING.must_speak(now_ms * MS, is_gone=False) is speaks


def test_a_bridge_that_is_gone_is_spoken_for_at_once():
    assert DRIVING.must_speak(100 * MS, is_gone=True)


def test_two_seconds_after_the_last_motion_a_person_may_drive():
    assert DRIVING.must_speak(100 * MS + HELD_NS - 1, is_gone=False)
    assert not DRIVING.must_speak(100 * MS + HELD_NS, is_gone=False)
    assert not DRIVING.must_speak(100 * MS + HELD_NS, is_gone=True)


def test_a_robot_that_stood_long_enough_needs_nobody():
    standing = DRIVING.heard(100 * MS + HELD_NS, moves=False)
    assert not standing.must_speak(10**12, is_gone=False)


def test_a_standstill_that_was_said_once_may_have_been_lost():
    assert DRIVING.heard(110 * MS, moves=False).must_speak(150 * MS, is_gone=False)


def test_a_bridge_that_speaks_again_is_watched_again():
    back = DRIVING.heard(5000 * MS, moves=True)
    assert not back.must_speak(5039 * MS, is_gone=False)
    assert back.must_speak(5040 * MS, is_gone=False)


def test_the_next_look_is_when_a_silence_would_begin_and_then_every_period():
    assert DRIVING.look_ns(110 * MS) == 140 * MS
    assert DRIVING.look_ns(139 * MS) == 140 * MS
    assert DRIVING.look_ns(140 * MS) == 160 * MS
    assert NEW.look_ns(0) == PERIOD_NS
