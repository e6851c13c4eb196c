"""A robot that speaks ROS 2: its router and its wheels live here, all else in processes."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from campaigns.ends.crew import MAIN, Member, Motion
from campaigns.ends.kinds import Kind
from campaigns.ends.on_bus import told_ms
from support import ros2_robot
from support.ros2_base import HOLDS_FOR_EVER, WITH_TIMEOUT, rolled
from support.ros2_drives import FAST_ENOUGH, moves
from support.ros2_robot import Told

BASES = {"holds": HOLDS_FOR_EVER, "time-out": WITH_TIMEOUT}
_RECENT_NS = 100_000_000


@dataclass
class RosRobot:
    """A robot, and what its wheels were told."""

    members: dict[str, Member]
    told: list[Told]

    def drives(self) -> bool:
        """See `Robot.drives`."""
        last = self.told[-25:]
        return moves(last) and time.time_ns() - last[-1].arrived_ns < _RECENT_NS

    def motion(self, kind: Kind, since_ns: int, until_ns: int) -> Motion:
        """See `Robot.motion`."""
        told = list(self.told)
        after = next((n for n, w in enumerate(told) if w.arrived_ns > since_ns), len(told))
        words = [w for w in told[max(0, after - 1) :] if w.arrived_ns <= until_ns]
        heard = [(w.arrived_ns, w.is_standstill) for w in words if w.arrived_ns > since_ns]
        said_ms = told_ms(heard, since_ns, kind.is_quick)
        if kind.is_quick or kind.drives_on:
            return Motion(said_ms)
        rolls = {name: rolled(base, words, since_ns, until_ns) for name, base in BASES.items()}
        return Motion(
            said_ms,
            {name: 1e3 * roll.standstill_s for name, roll in rolls.items()},
            {name: 1e3 * roll.distance_m for name, roll in rolls.items()},
        )


@contextmanager
def ros_robot(policy: Path, port: int, backend: str) -> Iterator[RosRobot]:
    """A robot whose router listens at this port; without processes."""
    bridge = [MAIN, "ros2", "--port", port, *FAST_ENOUGH, "--auto-arm"]
    runtime = [MAIN, "run", policy, "--input", "scan", "--port", port, "--backend", backend]
    scanner = ["campaigns.ends.scanner", port, "scan"]
    members = {
        "scanner": Member(lambda: list(scanner), "scanner: ready"),
        "bridge": Member(lambda: list(bridge), "reflexarc ros2: "),
        "runtime": Member(lambda: list(runtime), "; watchdog on"),
    }
    with ros2_robot.router(port) as session:
        wheels = ros2_robot.Robot(session, "scan", "cmd_vel", stamped=False)
        subscriber = session.declare_subscriber("cmd_vel", wheels.hear)
        try:
            yield RosRobot(members, wheels.told)
        finally:
            subscriber.undeclare()  # type: ignore[no-untyped-call]  # the stub has no type
