from collections.abc import Callable, Iterator
from typing import Any

import pytest
from foxglove_schemas_protobuf.Log_pb2 import Log

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.messages.topics import ARM, STOP, topic_of
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from reflexarc_sim_bridge.body.ros2.bridge import FAREWELLS, RosBridge, RosBridgeReport
from reflexarc_sim_bridge.body.ros2.route import Route
from reflexarc_sim_bridge.body.ros2.turns import Turn
from reflexarc_sim_bridge.body.ros2.wires import RmwWire, Ros2DdsWire
from support.gates import drive, hold, message
from support.sensing import MS
from support.spoken import FakeBus

LIMITS = BodyLimits(1.0, 0.5, 2.0)


class GivenTurns:
    """The turns that a test gives, in place of a clock; an exception among them is raised."""

    def __init__(self, *turns: Turn | Exception) -> None:
        self._turns: Iterator[Turn | Exception] = iter(turns)
        self.spoken_ms: list[float] = []
        self.between: Callable[[], object] = lambda: None

    def wait(self, should_stop: Callable[[], bool]) -> Turn | None:
        if self.spoken_ms:
            self.between()
        turn = next(self._turns, None)
        if isinstance(turn, Exception):
            raise turn
        return turn

    def spoke(self, now_ns: int) -> None:
        self.spoken_ms.append(now_ns / MS)

    def rest(self, duration_ns: int) -> int:
        return 50 * MS

    def now_ns(self) -> int:
        return 50 * MS


class Mortal:
    """A companion that has ended."""

    def is_alive(self) -> bool:
        return False


def turn(time_ms: int, *messages: Message, due: bool = False) -> Turn:
    return Turn(time_ms * MS, messages, due)


def served(
    turns: GivenTurns, auto_arm: bool = True, watcher: Any = None
) -> tuple[FakeBus, Callable[[], RosBridgeReport]]:
    bus: Any = FakeBus()
    inbox = Inbox()
    settings = GateSettings(0.2, LIMITS, auto_arm)
    route = Route(Ros2DdsWire(), "/scan", "/cmd_vel")
    bridge = RosBridge(bus, route, inbox, settings, watcher)
    given: Any = turns
    return bus, lambda: bridge.serve(given, lambda: False)


def test_a_command_goes_out_when_it_comes_and_what_is_refused_makes_no_twist():
    good, anonymous = drive(30 * MS, received_ns=31 * MS), drive(30 * MS, sender=None)
    turns = GivenTurns(turn(20, due=True), turn(31, good), turn(33, anonymous), turn(51, due=True))
    bus, serve = served(turns)
    report = serve()
    assert turns.spoken_ms == [20, 31, 51]
    assert [ahead for ahead, _, _ in bus.publishers["cmd_vel"].speeds[:3]] == [0.0, 1.0, 1.0]
    assert (report.commands, report.twists) == (2, 3 + FAREWELLS)
    assert report.refused_commands == {"no attachment that names a sender": 1}


def test_a_stop_wakes_the_bridge_and_has_an_inbox_of_its_own():
    inbox = Inbox(capacity=4)
    bus: Any = FakeBus()
    RosBridge(bus, Route(Ros2DdsWire(), "/scan", "/cmd_vel"), inbox, GateSettings(0.2, LIMITS))
    bus.heard["stop"](message(STOP))
    woken = inbox.take(0.0)
    assert woken is not None
    assert topic_of(woken.key) is None


@pytest.mark.parametrize(
    ("topic", "one"),
    [("command", drive(30 * MS)), ("arm", message(ARM)), ("hold_to_run", hold(0))],
)
def test_a_flood_does_not_push_a_stop_out(topic: str, one: Message):
    turns = GivenTurns(turn(0, due=True), turn(31, drive(30 * MS, received_ns=31 * MS)))
    bus, serve = served(turns)
    bus.heard["stop"](message(STOP))
    for _ in range(3000):
        bus.heard[topic](one)
    serve()
    assert all(speeds == (0.0, 0.0, 0.0) for speeds in bus.publishers["cmd_vel"].speeds)


def test_a_loop_that_fails_still_tells_the_robot_to_stand_again_and_again():
    bus, serve = served(GivenTurns(RuntimeError("on purpose")))
    with pytest.raises(RuntimeError, match="on purpose"):
        serve()
    assert bus.publishers["cmd_vel"].speeds == [(0.0, 0.0, 0.0)] * FAREWELLS


def test_a_robot_says_once_a_second_what_it_does_at_most():
    bus, serve = served(GivenTurns(*(turn(slot * 500, due=True) for slot in range(5))))
    serve()
    said = [(decode_body(payload), time_ns) for payload, time_ns in bus.publishers["body"].said]
    assert said == [(BodyInfo(limits=LIMITS), second * 1000 * MS) for second in range(3)]


def test_whom_it_obeys_is_said_at_once_and_what_it_refused_once_a_second():
    turns = GivenTurns(turn(0, due=True), turn(10), turn(20, due=True))
    bus, serve = served(turns, auto_arm=False)
    turns.between = lambda: bus.heard["arm"](message(ARM))
    serve()
    leases = [pb.Lease.FromString(payload) for payload, _ in bus.publishers["lease"].said]
    assert [lease.armed for lease in leases] == [False, True]


def test_the_status_counts_what_was_refused_and_says_that_nobody_watches():
    fast = drive(30 * MS, linear_mps=100.0, received_ns=31 * MS)
    bus, serve = served(GivenTurns(turn(31, fast), turn(1500, due=True)), watcher=Mortal())
    serve()
    statuses = [pb.Status.FromString(payload) for payload, _ in bus.publishers["status"].said]
    assert dict(statuses[-1].verdicts) == {
        "too fast: slowed down": 1,
        "nobody watches the twists": 2,
    }


def test_that_the_companion_is_lost_is_said_once_on_the_robot_s_log():
    turns = GivenTurns(*[turn(time_ms, due=True) for time_ms in (0, 1500, 3000)])
    bus, serve = served(turns, watcher=Mortal())
    serve()
    ((payload, time_ns),) = bus.publishers["log"].said
    said = Log.FromString(payload)
    assert (said.level, said.name, time_ns) == (Log.WARNING, "body", 0)
    assert "nobody watches the twists" in said.message


def test_without_a_companion_none_is_missed_on_the_log():
    bus, serve = served(GivenTurns(turn(0, due=True)), watcher=None)
    serve()
    assert bus.publishers["log"].said == []


def test_the_odometry_is_on_the_key_of_the_robot_s_wire():
    rmw = Route(RmwWire(3), "/scan", "/cmd_vel", odometry="/odom")
    assert rmw.odometry_key.startswith("3/odom/nav_msgs::msg::dds_::Odometry_/RIHS01_3cc97dc7")
    assert Route(RmwWire(3), "/scan", "/cmd_vel").odometry_key == ""


def test_what_is_declared_on_rmw():
    bus: Any = FakeBus()
    inbox = Inbox()
    settings = GateSettings(0.2, LIMITS)
    RosBridge(bus, Route(RmwWire(3), "/scan", "/cmd_vel", stamped=True), inbox, settings)
    assert [key for key in bus.heard if key.startswith("3/scan/sensor_msgs::msg::dds_::LaserScan_")]
    assert {"command", "stop", "reset", "arm", "release"} < bus.heard.keys()
    assert [key for key in bus.publishers if "::TwistStamped_/RIHS01_5f0fcd4f" in key]
    assert sum(token.startswith("@ros2_lv/3/ab/") for token in bus.tokens) == 3
    assert bus.tokens[-1] == "body"


def test_odometry_and_transforms_are_heard_and_announced_where_the_robot_has_them():
    bus: Any = FakeBus()
    route = Route(RmwWire(3), "/b/scan", "/b/cmd_vel", odometry="/b/odom", tf="/tf")
    RosBridge(bus, route, Inbox(), GateSettings(0.2, LIMITS))
    heard = {key.split("/sensor_msgs")[0].split("/nav_msgs")[0] for key in bus.heard}
    assert {"3/b/scan", "3/b/odom"} < heard
    static = [key for key in bus.heard if key.startswith("3/tf_static/tf2_msgs::msg::dds_::TFM")]
    assert [key for key in bus.heard if key.startswith("3/tf/tf2_msgs::msg::dds_::TFMessage_/")]
    # A static transform was said before the bridge began: its publisher's cache is asked for it.
    assert bus.asked == [f"{static[0]}/@adv/pub/**?_anyke;_max=100"]
    latched = [token for token in bus.tokens if "%tf_static/" in token]
    assert [token.rpartition("/")[2] for token in latched] == [":1:,100:,:,:,,"]
    assert len({token.split("/")[4] for token in bus.tokens[:-1]}) == 6  # numbers tell them apart
