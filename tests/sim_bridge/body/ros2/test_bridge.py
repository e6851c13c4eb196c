import math
import struct
from typing import Any

import pytest

from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Command, Input, Verdict, drive_command, safe_command
from reflexarc_runtime.loop.pacer import Wakeup
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.messages.codec import encode_command
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.bridge import CommandRelay, RosBridge, Route, ScanRelay
from reflexarc_sim_bridge.body.ros2.wires import RmwWire, Ros2DdsWire
from support.ros2 import Time, Twist, TwistStamped, laser_scan
from support.sensing import MS

GO = Action("left", 1.0, 0.5, 0.25)
CREEP = Action("creep", 0.1, 0.0)
WALL_NS = 1_700_000_000_000_000_000


class Spoken:
    """A publisher that keeps what it is given."""

    def __init__(self) -> None:
        self.said: list[tuple[bytes, int]] = []

    def put(self, payload: bytes, time_ns: int) -> None:
        self.said.append((payload, time_ns))


def relay(stamped: bool = False) -> tuple[CommandRelay, Spoken]:
    spoken: Any = Spoken()
    return CommandRelay(spoken, stamped, wall_offset=lambda: WALL_NS), spoken


def message(payload: bytes, received_ns: int = 0) -> Message:
    return Message("robot0/command", payload, "", b"", received_ns)


def drive(source_ns: int, motion: Action = GO) -> Message:
    echo = Input(7, source_ns, source_ns, 0)
    return message(encode_command(drive_command(3, 1, motion, echo, valid_for_ns=100 * MS)))


def speeds(spoken: Spoken) -> list[tuple[float, float, float]]:
    twists = [Twist.deserialize(payload) for payload, _ in spoken.said]
    return [(twist.linear.x, twist.linear.y, twist.angular.z) for twist in twists]


def test_the_robot_stands_until_it_is_told_to_go():
    command, spoken = relay()
    command.speak(20 * MS)
    command.hear(drive(source_ns=30 * MS))
    command.speak(40 * MS)
    assert speeds(spoken) == [(0.0, 0.0, 0.0), (1.0, 0.5, 0.25)]
    assert (command.twists, command.standstills, command.commands) == (2, 1, 1)


def test_a_command_is_repeated_while_it_holds_and_then_the_robot_stands():
    command, spoken = relay()
    command.hear(drive(source_ns=30 * MS))
    for now_ms in (40, 60, 129, 130, 150):
        command.speak(now_ms * MS)
    assert [ahead for ahead, _, _ in speeds(spoken)] == [1.0, 1.0, 1.0, 0.0, 0.0]


def test_a_safe_command_means_standstill_whatever_its_speeds():
    command, spoken = relay()
    command.hear(message(encode_command(safe_command(4, Verdict.STALE_INPUT, CREEP))))
    command.speak(40 * MS)
    assert speeds(spoken) == [(0.0, 0.0, 0.0)]


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_counted_and_never_sent(speed: float):
    command, spoken = relay()
    bad = Command(3, 1, Verdict.OK, 1.0, 0.0, speed, 100 * MS, 7, 30 * MS)
    command.hear(message(encode_command(bad)))
    command.hear(message(b"noise"))
    command.speak(40 * MS)
    assert speeds(spoken) == [(0.0, 0.0, 0.0)]
    assert (command.commands, command.refused) == (0, 2)


def test_stamped_commands_bear_the_wall_clock_of_the_moment():
    command, spoken = relay(stamped=True)
    command.hear(drive(source_ns=0))
    command.speak(40 * MS)
    stamped = TwistStamped.deserialize(spoken.said[0][0])
    assert stamped.header.stamp == Time(1_700_000_000, 40 * MS)
    assert stamped.header.frame_id == "base_link"
    assert stamped.twist.linear.x == 1.0
    assert spoken.said[0][1] == WALL_NS + 40 * MS


def test_scans_leave_with_the_time_of_their_arrival():
    spoken: Any = Spoken()
    scans = ScanRelay(spoken)
    scans.hear(message(laser_scan([1.0, 2.0]).serialize(), received_ns=123))
    assert [time_ns for _, time_ns in spoken.said] == [123]
    assert scans.scans == 1


def test_what_is_no_scan_is_counted_by_reason_and_said_once(caplog: pytest.LogCaptureFixture):
    spoken: Any = Spoken()
    scans = ScanRelay(spoken)
    for payload in (b"noise", b"more noise", laser_scan([]).serialize()):
        scans.hear(message(payload))
    assert spoken.said == []
    assert scans.refused == {"no little-endian CDR": 2, "fewer than 2 or more than 100000 beams": 1}
    assert [record.levelname for record in caplog.records] == ["WARNING", "WARNING"]


class FakeBus:
    """Remembers what was declared."""

    session_id = "ab"

    def __init__(self) -> None:
        self.publishers: dict[str, Spoken] = {}
        self.heard: list[str] = []
        self.tokens: list[str] = []

    def publisher(self, topic: Any) -> Spoken:
        return self.publishers.setdefault(topic.name, Spoken())

    def publisher_of_key(self, key: str, encoding: str, quality: Any) -> Spoken:
        return self.publishers.setdefault(key, Spoken())

    def subscribe(self, topics: Any, deliver: Any) -> None:
        self.heard += [topic.name for topic in topics]

    def subscribe_to_key(self, key: str, deliver: Any) -> None:
        self.heard.append(key)

    def announce(self, node: str) -> None:
        self.tokens.append(node)

    def announce_key(self, key: str) -> None:
        self.tokens.append(key)


class FailingPacer:
    """Fails at once, at 50 ms."""

    def wait(self, should_stop: Any) -> Any:
        raise RuntimeError("on purpose")

    def now_ns(self) -> int:
        return 50 * MS


def test_a_loop_that_fails_still_tells_the_robot_to_stand():
    bus: Any = FakeBus()
    pacer: Any = FailingPacer()
    inbox: Any = type("NoInbox", (), {"put": None})
    bridge = RosBridge(bus, Route(Ros2DdsWire(), "/scan", "/cmd_vel"), inbox)
    with pytest.raises(RuntimeError, match="on purpose"):
        bridge.serve(pacer, lambda: False)
    assert speeds(bus.publishers["cmd_vel"]) == [(0.0, 0.0, 0.0)]
    assert bridge.account.standstills == 1


def woken_at(now_ns: int) -> Wakeup:
    return Wakeup(0, now_ns, now_ns, now_ns, (), 0)


class HalfSeconds(FailingPacer):
    """Wakes up five times, every half second."""

    def __init__(self) -> None:
        self._wakeups = iter([woken_at(slot * 500 * MS) for slot in range(5)])

    def wait(self, should_stop: Any) -> Any:
        return next(self._wakeups, None)


def test_a_robot_says_once_a_second_that_it_is_not_simulated():
    bus: Any = FakeBus()
    pacer: Any = HalfSeconds()
    inbox: Any = type("NoInbox", (), {"put": None})
    RosBridge(bus, Route(Ros2DdsWire(), "/scan", "/cmd_vel"), inbox).serve(pacer, lambda: False)
    said = [(decode_body(payload), time_ns) for payload, time_ns in bus.publishers["body"].said]
    assert said == [(BodyInfo(), second * 1000 * MS) for second in range(3)]


def test_what_is_declared_on_rmw():
    bus: Any = FakeBus()
    inbox: Any = type("NoInbox", (), {"put": None})
    RosBridge(bus, Route(RmwWire(3), "/scan", "/cmd_vel", stamped=True), inbox)
    assert [key for key in bus.heard if key.startswith("3/scan/sensor_msgs::msg::dds_::LaserScan_")]
    assert [key for key in bus.publishers if "::TwistStamped_/RIHS01_5f0fcd4f" in key]
    assert sum(token.startswith("@ros2_lv/3/ab/") for token in bus.tokens) == 3
    assert bus.tokens[-1] == "body"


def test_the_bytes_of_a_standstill():
    # CDR by hand: the envelope of little-endian, and six zeros of 8 bytes.
    command, spoken = relay()
    command.stop(0)
    assert spoken.said[0][0] == b"\x00\x01\x00\x00" + struct.pack("<6d", *[0.0] * 6)
