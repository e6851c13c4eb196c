"""`reflexarc ros2`: a robot that speaks ROS 2 over Zenoh becomes the body."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from reflexarc.terminal.output import aside, console, facts, plain, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc.wiring.limit_flags import LimitFlags
from reflexarc.wiring.scan_flags import ScanFlags
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_sim_bridge.body.gate.gate import GateSettings
    from reflexarc_sim_bridge.body.latch import StopLatch
    from reflexarc_sim_bridge.body.ros2.bridge import RosBridgeReport, Route
    from reflexarc_sim_bridge.body.ros2.companion_link import CompanionLink
    from reflexarc_sim_bridge.body.ros2.messages import RosScanner

MAX_RATE_HZ = 1000.0
SILENCE_S = 0.2
"""Whoever holds the robot and says nothing for so long loses it: twice the age at which an input
is too old by default, as no policy tells a robot its own."""


@dataclass(frozen=True)
class Ros2Command:
    """Connect a robot that speaks ROS 2 over Zenoh: scans in, velocity commands out.

    It joins where the robot's own Zenoh router listens (--port, 7447 for rmw_zenohd and
    zenoh-bridge-ros2dds), and so does `reflexarc run --input scan`. It needs the robot's largest
    speeds, obeys one runtime at a time, and stands until `reflexarc arm`. While no command is valid
    it tells the robot, --rate times a second, to stand. A companion process does so if it is
    killed. No ROS is needed on this machine.

    Examples:
      reflexarc ros2 --max-linear 0.5 --max-lateral 0 --max-angular 1
      reflexarc ros2 --limits robot.toml --mount 0.12 0 180 --no-return zero
      reflexarc ros2 --limits robot.toml --wire rmw --domain 7 --stamped
      reflexarc ros2 --limits robot.toml --topic robot1/scan --command robot1/cmd_vel
    """

    topic: str = "scan"
    """The robot's topic of sensor_msgs/LaserScan."""
    command: str = "cmd_vel"
    """The topic that the robot drives by."""
    stamped: bool = False
    """Send geometry_msgs/TwistStamped in place of geometry_msgs/Twist."""
    wire: Literal["ros2dds", "rmw"] = "ros2dds"
    """How ROS 2 meets Zenoh: by zenoh-plugin-ros2dds, or by rmw_zenoh."""
    domain: int = 0
    """ROS_DOMAIN_ID; it counts with rmw."""
    rate: float = 50.0
    """Commands to the robot, a second, at least."""
    ignore_scan_stamps: bool = False
    """Age counts from a scan's arrival alone: for simulators whose time runs slower than ours."""
    robot_limits: LimitFlags = field(default_factory=LimitFlags)
    scanner: ScanFlags = field(default_factory=ScanFlags)
    auto_arm: bool = False
    """Drive as soon as a runtime says so, without `reflexarc arm`."""
    no_companion: bool = False
    """Go without the process that stops the robot if this one is killed or hangs."""
    state: Path = Path("runs")
    """Folder in which a stop is kept until its reset."""
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Serve until the end, then say what went over the bridge."""
        from reflexarc_runtime.messages.topics import BODY_NODE

        route, settings = self._route(), self._settings()
        with StopFlag() as stop, self.joining.bus(BODY_NODE) as bus:
            account = self._serve(bus, route, settings, stop)
        self._tell(account)
        return 0

    def _settings(self) -> "GateSettings":
        from reflexarc_sim_bridge.body.gate.gate import GateSettings

        return GateSettings(SILENCE_S, self.robot_limits.body_limits(), self.auto_arm)

    def _route(self) -> "Route":
        from reflexarc_runtime.messages.topics import COMMAND, SCAN
        from reflexarc_sim_bridge.body.ros2.bridge import Route
        from reflexarc_sim_bridge.body.ros2.key_expressions import check_topic
        from reflexarc_sim_bridge.body.ros2.wires import wire_named

        if not 0.0 < self.rate <= MAX_RATE_HZ:
            raise UsageError(f"--rate: expected 0 to {MAX_RATE_HZ:g} Hz, got {self.rate}")
        route = Route(
            wire_named(self.wire, self.domain),
            check_topic("--topic", self.topic),
            check_topic("--command", self.command),
            self.stamped,
            self._scanner(),
            not self.ignore_scan_stamps,
        )
        for key in (SCAN.key(self.joining.robot), COMMAND.key(self.joining.robot)):
            if key in (route.scan_key, route.command_key):
                raise UsageError(
                    f"{key}: expected the robot's keys and ours to differ; "
                    "give ours another first part with --robot"
                )
        return route

    def _scanner(self) -> "RosScanner":
        from reflexarc_runtime.sensing.mounting import CENTRED
        from reflexarc_sim_bridge.body.ros2.messages import RosScanner

        flags = self.scanner
        return RosScanner(flags.meaning, flags.known_mount or CENTRED, flags.ignored)

    def _serve(
        self, bus: "Bus", route: "Route", settings: "GateSettings", stop: StopFlag
    ) -> "RosBridgeReport":
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.inbox import Inbox
        from reflexarc_sim_bridge.body.ros2.bridge import RosBridge
        from reflexarc_sim_bridge.body.ros2.turns import Turns

        inbox = Inbox()
        turns = Turns(self.rate, MonotonicClock(), inbox)
        with self._companion(bus, route, turns.period_ns) as watcher:
            bridge = RosBridge(bus, route, inbox, settings, watcher, self._latch())
            aside.print(
                f"reflexarc ros2: {route.scan} → {route.command} on {self.wire}, {self.rate:g} Hz"
            )
            return bridge.serve(turns, stop)

    def _latch(self) -> "StopLatch":
        """The stop that outlives the bridge."""
        from reflexarc_sim_bridge.body.latch import StopLatch

        latch = StopLatch(self.state, self.joining.robot)
        if latch.stopped:
            reason = plain(latch.stopped)
            aside.print(f"reflexarc ros2: stopped ({reason}) until `reflexarc reset`")
        return latch

    def _companion(
        self, bus: "Bus", route: "Route", period_ns: int
    ) -> "AbstractContextManager[CompanionLink | None]":
        from reflexarc_sim_bridge.body.ros2.companion import Watched
        from reflexarc_sim_bridge.body.ros2.companion_link import CompanionLink

        if self.no_companion:
            return nullcontext()
        watched = Watched(
            robot=self.joining.robot,
            port=self.joining.port,
            zenoh="" if self.joining.zenoh is None else str(self.joining.zenoh.absolute()),
            command_key=route.command_key,
            stamped=self.stamped,
            sender=bus.sender.hex(),
            period_ns=period_ns,
        )
        return CompanionLink(watched)

    def _tell(self, account: "RosBridgeReport") -> None:
        if self.json:
            print_json(account)
            return
        console.print(
            facts(
                {
                    "scans": account.scans,
                    "refused scans": _counts(account.refused_scans),
                    "commands": account.commands,
                    "refused commands": _counts(account.refused_commands),
                    "twists": f"{account.twists}, {account.standstills} of them standstill",
                }
            )
        )


def _counts(reasons: dict[str, int]) -> str:
    return ", ".join(f"{count} {reason}" for reason, count in reasons.items()) or "none"
