"""A robot on the project's own bus: the simulated body, with its gate, limits and inertia."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from campaigns.ends.crew import MAIN, Member, Motion
from campaigns.ends.kinds import Kind
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.topics import COMMAND, POSE, topic_of
from reflexarc_runtime.messages.wire import Message

STEP_S = 0.02
BASE = "simulated"
WORLD = """name = "empty"
width_m = 20.0
edges = "unbounded"
layers = []
[chassis]
acceleration_mps2 = 2.0   # of braking, too
[limits]
linear_mps = 1.0
valid_for_s = 0.1
"""
_LESS_MPS = 0.005
"""A step of braking takes 0.04 m/s off."""
_SOME = 15
_SOME_NS = 600_000_000
"""Twice the time that so many poses take, and less than any end is watched."""


@dataclass
class BusRobot:
    """A simulated robot, and what is heard of it."""

    members: dict[str, Member]
    poses: list[tuple[int, float, float]] = field(default_factory=list)
    """(arrival on the wall clock in ns, x, y)."""
    commands: list[tuple[int, bool]] = field(default_factory=list)
    """(arrival, whether it told the body to stand)."""

    def hear(self, message: Message) -> None:
        """Take a pose or a command."""
        if topic_of(message.key) is POSE:
            place = PoseInFrame.FromString(message.payload).pose.position
            self.poses.append((message.received_ns, place.x, place.y))
        elif (command := decode_command(message.payload)) is not None:
            self.commands.append((message.received_ns, command.is_safe))

    def drives(self) -> bool:
        """See `Robot.drives`."""
        last = self.poses[-_SOME - 1 :]
        speeds = _speeds(last)
        if len(speeds) < _SOME or time.time_ns() - last[0][0] > _SOME_NS:
            return False  # not all of one body, or of long ago
        return all(speed_mps > 0.99 for _, speed_mps in speeds)

    def motion(self, kind: Kind, since_ns: int, until_ns: int) -> Motion:
        """See `Robot.motion`. A body that has ended moves no more: its runtime must tell that."""
        poses = list(self.poses)
        before = max((n for n, pose in enumerate(poses) if pose[0] <= since_ns), default=0)
        speeds = _speeds([pose for pose in poses[before:] if pose[0] <= until_ns])
        way_mm = 1e3 * STEP_S * sum(speed for _, speed in speeds)
        rolled_mm = {} if kind.is_quick else {BASE: way_mm}
        if kind.victim == "body":
            commands = [(at, stands) for at, stands in self.commands if since_ns < at <= until_ns]
            return Motion(told_ms(commands, since_ns, kind.is_quick), {}, rolled_mm)
        slowing = [
            (at, now < before - _LESS_MPS or now == 0.0)
            for (_, before), (at, now) in pairwise(
                [(since_ns, speeds[0][1] if speeds else 0.0), *speeds]
            )
        ]
        stand_ms = {} if kind.is_quick else {BASE: _stand_ms(speeds, since_ns)}
        return Motion(told_ms(slowing, since_ns, kind.is_quick), stand_ms, rolled_mm)


def told_ms(words: list[tuple[int, bool]], since_ns: int, first: bool) -> float:
    """When somebody was told to stand.

    Args:
        words: (time, whether it was a word to stand), all after `since_ns`.
        since_ns: from when on it counts.
        first: the first such word counts; else the first one that no other word followed.

    Returns:
        Milliseconds; infinite if it was not.
    """
    told_ns = None
    for at_ns, stands in words:
        if not stands and not first:
            told_ns = None
        elif stands and told_ns is None:
            told_ns = at_ns
    return math.inf if told_ns is None else (told_ns - since_ns) * 1e-6


@contextmanager
def bus_robot(policy: Path, port: int, backend: str, folder: Path) -> Iterator[BusRobot]:
    """A robot on the bus without processes; they join at this port."""
    world = folder / "empty.toml"
    world.write_text(WORLD)
    body = [MAIN, "sim", "--world", world, "--policy", policy, "--allow-body", "--port", port]
    runtime = [MAIN, "run", policy, "--port", port, "--backend", backend]
    members = {
        "body": Member(lambda: list(body), "reflexarc sim: "),
        "runtime": Member(lambda: list(runtime), "; watchdog on"),
    }
    robot = BusRobot(members)
    with Bus(BusConfig(port=port), time.time_ns) as bus:
        bus.subscribe([POSE, COMMAND], robot.hear)
        yield robot


def _speeds(poses: list[tuple[int, float, float]]) -> list[tuple[int, float]]:
    """(arrival, m/s): by the way of each step; a new body begins elsewhere, which is no step."""
    steps = [(b[0], math.dist(a[1:], b[1:]) / STEP_S) for a, b in pairwise(poses)]
    return [(at_ns, speed_mps) for at_ns, speed_mps in steps if speed_mps < 2.0]


def _stand_ms(speeds: list[tuple[int, float]], since_ns: int) -> float:
    stood_ns = None
    for at_ns, speed_mps in speeds:
        stood_ns = None if speed_mps > 1e-6 else (stood_ns or at_ns)
    return math.inf if stood_ns is None else (stood_ns - since_ns) * 1e-6
