import math
from pathlib import Path
from typing import Any

import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.topics import ARM, RELEASE, RESET, STOP
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from reflexarc_sim_bridge.body.latch import StopLatch
from reflexarc_sim_bridge.body.ros2.command_relay import CommandRelay
from reflexarc_sim_bridge.body.ros2.twists import TwistPublisher
from support.gates import BODY, ONE, OTHER, drive, message, safe
from support.sensing import MS
from support.spoken import Spoken

LIMITS = BodyLimits(linear_mps=1.0, lateral_mps=0.5, angular_radps=2.0)


def relay(
    auto_arm: bool = True, limits: BodyLimits = LIMITS, latch: StopLatch | None = None
) -> tuple[CommandRelay, Spoken]:
    spoken: Any = Spoken()
    gate = Gate.closed(BODY, GateSettings(0.2, limits, auto_arm))
    return CommandRelay(TwistPublisher(spoken, None, wall_offset=lambda: 0), gate, latch), spoken


def at(time_ms: int) -> dict[str, int]:
    return {"received_ns": time_ms * MS}


def refused(command: CommandRelay) -> dict[str, int]:
    return dict(command.account.refused)


def test_the_robot_stands_until_it_is_told_to_go():
    command, spoken = relay()
    command.speak(20 * MS)
    assert command.hear([drive(30 * MS, lateral_mps=0.5, angular_radps=0.25, **at(35))])
    command.speak(40 * MS)
    assert spoken.speeds == [(0.0, 0.0, 0.0), (1.0, 0.5, 0.25)]
    assert (command.twists, command.standstills, command.heard) == (2, 1, 1)


def test_a_command_is_repeated_while_it_holds_and_then_the_robot_stands():
    command, spoken = relay()
    command.hear([drive(30 * MS, **at(35))])
    for now_ms in (40, 60, 129, 130, 150):
        command.speak(now_ms * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == [1.0, 1.0, 1.0, 0.0, 0.0]


def test_a_safe_command_means_standstill_whatever_its_speeds():
    command, spoken = relay()
    command.hear([drive(30 * MS, **at(35)), safe(linear_mps=0.1)])
    command.speak(40 * MS)
    assert spoken.speeds == [(0.0, 0.0, 0.0)]


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_counted_and_never_sent(speed: float):
    command, spoken = relay()
    bad = drive(30 * MS, angular_radps=speed, **at(35))
    assert not command.hear([bad, drive(30 * MS, payload=b"noise", **at(36))])
    command.speak(40 * MS)
    assert spoken.speeds == [(0.0, 0.0, 0.0)]
    assert refused(command) == {"unreadable, or speeds that are not finite": 2}


def test_a_hundred_metres_a_second_become_the_robot_s_own_largest_speed_and_are_counted():
    command, spoken = relay()
    command.hear([drive(30 * MS, linear_mps=100.0, lateral_mps=-10.0, **at(35))])
    command.speak(40 * MS)
    assert spoken.speeds == [(1.0, pytest.approx(-0.1), 0.0)]
    assert refused(command) == {"too fast: slowed down": 1}


def test_a_robot_that_nobody_armed_stands():
    command, spoken = relay(auto_arm=False)
    command.hear([drive(30 * MS, **at(35))])
    command.speak(40 * MS)
    command.hear([message(ARM, **at(50)), drive(50 * MS, **at(55))])
    command.speak(60 * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == [0.0, 1.0]
    assert refused(command) == {"the body is not armed": 1}


def test_a_stop_is_news_and_holds_until_a_reset():
    command, spoken = relay()
    command.hear([drive(30 * MS, **at(35))])
    assert command.hear([message(STOP, **at(40))])
    command.speak(40 * MS)
    command.hear([drive(50 * MS, **at(55))])
    command.speak(60 * MS)
    command.hear([message(RESET, **at(65)), drive(65 * MS, **at(70))])
    command.speak(70 * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == [0.0, 0.0, 1.0]


def test_an_anonymous_command_and_those_of_a_second_brain_are_no_news():
    command, spoken = relay()
    assert not command.hear([drive(0, sender=None, valid_for_ns=2**63 - 1, **at(10))])
    command.hear([drive(20 * MS, ONE, 0.25, **at(25))])
    assert not command.hear([drive(20 * MS, OTHER, 1.0, **at(26))])
    command.speak(30 * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == [0.25]


def test_who_releases_the_robot_leaves_it_standing_for_the_next():
    command, spoken = relay()
    command.hear([drive(20 * MS, ONE, **at(25)), message(RELEASE, sender=ONE, **at(30))])
    command.speak(30 * MS)
    command.hear([drive(40 * MS, OTHER, 0.5, **at(45))])
    command.speak(50 * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == [0.0, 0.5]


def test_a_speed_grows_by_the_acceleration_and_the_time_since_the_last_twist():
    command, spoken = relay(limits=BodyLimits(1.0, 0.5, 2.0, acceleration_mps2=2.0))
    for now_ms in (20, 40, 60):
        command.hear([drive(now_ms * MS, **at(now_ms))])
        command.speak(now_ms * MS)
    command.stop(70 * MS)
    assert [ahead for ahead, _, _ in spoken.speeds] == pytest.approx([0.0, 0.04, 0.08, 0.0])


def test_a_stop_outlives_the_bridge(tmp_path: Path):
    command, _ = relay(latch=StopLatch(tmp_path, "robot0"))
    command.hear([message(STOP, pb.Stop(reason="a dog").SerializeToString())])
    command.speak(20 * MS)
    assert StopLatch(tmp_path, "robot0").stopped == command.account.stopped == "a dog"
    command.hear([message(RESET)])
    command.speak(40 * MS)
    assert StopLatch(tmp_path, "robot0").stopped == ""
