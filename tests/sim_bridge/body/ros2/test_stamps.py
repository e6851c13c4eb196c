"""Stamps of twists against the rule of diff_drive_controller, with clocks that disagree."""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.gate import Gate, GateSettings
from reflexarc_sim_bridge.body.ros2.command_relay import CommandRelay
from reflexarc_sim_bridge.body.ros2.companion import Watched
from reflexarc_sim_bridge.body.ros2.scan_relay import ScanRelay
from reflexarc_sim_bridge.body.ros2.stamps import (
    REMEMBERED_SCANS,
    ScanStamps,
    Stamper,
    StampRule,
)
from reflexarc_sim_bridge.body.ros2.twists import TwistPublisher
from support.diff_drive import TIMEOUT_NS, DiffDrive
from support.gates import BODY, drive
from support.ros2 import Time, laser_scan
from support.sensing import MS
from support.spoken import Spoken

SECOND_NS = 1_000_000_000
ROBOT_NS = 1_700_000_000 * SECOND_NS
"""What the robot's clock is ahead of our monotonic one."""
ENDS_NS = 2 * SECOND_NS
VALID_NS = 100 * MS
PERIOD_NS = 20 * MS


@dataclass
class Wheels:
    """Twists go straight to the controller; the robot's time is ours and a constant."""

    drive: DiffDrive = field(default_factory=DiffDrive)
    now_ns: int = 0

    def put(self, payload: bytes, time_ns: int) -> None:
        self.drive.hear(payload, ROBOT_NS + self.now_ns)


def clock_of(ahead_s: float) -> Callable[[], int]:
    return lambda: ROBOT_NS + round(ahead_s * SECOND_NS)


class Road:
    """A robot that scans every 20 ms, a runtime that answers each scan, and a bridge between."""

    def __init__(self, rule: StampRule, ahead_s: float) -> None:
        self.wheels: Any = Wheels()
        scans = ScanStamps()
        stamper = Stamper(rule, clock_of(ahead_s), scans)
        unheard: Any = Spoken()
        self.scans = ScanRelay(unheard, scans)
        gate = Gate.closed(BODY, GateSettings(0.2, BodyLimits(1.0, 1.0, 1.0), auto_arm=True))
        self.bridge = CommandRelay(TwistPublisher(self.wheels, stamper, lambda: 0), gate)

    def step(self, now_ns: int, *, scanner: bool = True, bridge: bool = True) -> float:
        """Two hundredths of a second; the speed of the wheels."""
        self.wheels.now_ns = now_ns
        if scanner:
            seconds, rest_ns = divmod(ROBOT_NS + now_ns - 3 * MS, SECOND_NS)  # 3 ms on the way
            scan = laser_scan([9.0, 9.0], stamp=Time(seconds, rest_ns)).serialize()
            self.scans.hear(Message("scan", scan, "", b"", now_ns))
        if bridge:
            if scanner:
                self.bridge.hear([drive(now_ns, received_ns=now_ns)])
            self.bridge.speak(now_ns)
        return self.wheels.drive.speed_mps(ROBOT_NS + now_ns)

    def driven_s(self, **after: bool) -> tuple[float, float]:
        """How long the wheels turn before the end of something, and from there on."""
        speeds = [self.step(t) for t in range(PERIOD_NS, ENDS_NS, PERIOD_NS)]
        rest = [self.step(t, **after) for t in range(ENDS_NS, 4 * ENDS_NS, PERIOD_NS)]
        return sum(speeds) * PERIOD_NS / SECOND_NS, sum(rest) * PERIOD_NS / SECOND_NS


@pytest.mark.parametrize("ahead_s", [3.0, 0.0, -1.0])
@pytest.mark.parametrize("rule", [StampRule.SCAN, StampRule.ZERO])
def test_whatever_our_clock_says_the_robot_drives_and_its_own_time_out_works(
    rule: StampRule, ahead_s: float
):
    before_s, after_s = Road(rule, ahead_s).driven_s(bridge=False)  # killed, and no companion
    assert before_s == pytest.approx(1.98)
    assert after_s * SECOND_NS <= TIMEOUT_NS + PERIOD_NS


def test_our_wall_clock_defeats_the_time_out_when_it_is_ahead_and_freezes_the_robot_when_behind():
    # As it was before, and still is with --stamp wall: 3 s and the time-out; nothing at all.
    assert Road(StampRule.WALL, 3.0).driven_s(bridge=False)[1] == pytest.approx(3.48, abs=0.03)
    assert Road(StampRule.WALL, -1.0).driven_s(bridge=False) == (0.0, 0.0)


@pytest.mark.parametrize("rule", [StampRule.SCAN, StampRule.ZERO])
def test_a_standstill_after_the_death_of_the_scanner_is_never_too_old(rule: StampRule):
    road = Road(rule, ahead_s=3.0)
    _, after_s = road.driven_s(scanner=False)
    assert after_s * SECOND_NS <= VALID_NS
    assert road.wheels.drive.ignored == 0


@pytest.mark.parametrize(
    ("rule", "expected_ns"),
    [
        (StampRule.SCAN, 0),
        (StampRule.ZERO, 0),
        (StampRule.WALL, ROBOT_NS + 5 * MS),
    ],
)
def test_the_companion_needs_no_scan_to_stamp_a_standstill(rule: StampRule, expected_ns: int):
    watched = Watched("robot0", 7447, "", "cmd_vel", True, "00" * 16, PERIOD_NS, stamp=rule)
    stamper = watched.stamper
    assert stamper is not None
    assert Stamper(stamper.rule, clock_of(0.0)).stamp_ns(5 * MS, None) == expected_ns


def test_a_motion_bears_the_stamp_of_the_scan_that_it_came_from_not_of_the_newest():
    stamps = ScanStamps()
    for number in range(10):
        stamps.note(number * PERIOD_NS, 1000 + number)
    stamper = Stamper(StampRule.SCAN, lambda: 0, stamps)
    assert stamper.stamp_ns(10 * PERIOD_NS, 4 * PERIOD_NS) == 1004
    assert stamper.stamp_ns(10 * PERIOD_NS, 4 * PERIOD_NS + 1) == 1004
    assert stamper.stamp_ns(10 * PERIOD_NS, -1) == 0


def test_stamps_are_remembered_for_a_while_and_read_while_scans_arrive():
    stamps = ScanStamps()
    writer = threading.Thread(target=lambda: [stamps.note(n, n) for n in range(20_000)])
    writer.start()
    seen = [stamps.at(20_000) for _ in range(2000)]
    writer.join()
    assert seen == sorted(seen)
    assert stamps.at(19_999 - REMEMBERED_SCANS) == 0
    assert stamps.at(20_000 - REMEMBERED_SCANS) == 20_000 - REMEMBERED_SCANS
