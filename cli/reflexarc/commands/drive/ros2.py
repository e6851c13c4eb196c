"""`reflexarc ros2`: a robot that speaks ROS 2 over Zenoh becomes the body."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from reflexarc.terminal.output import aside, console, facts, plain, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.body_flags import BodyFlags
from reflexarc.wiring.bus_flags import Joining
from reflexarc.wiring.limit_flags import LimitFlags
from reflexarc.wiring.robot_router import joined
from reflexarc.wiring.scan_flags import ScanFlags
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.wiring.waiting import Wish
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.ros2.laser_scan import RosScanner
    from reflexarc_sim_bridge.body.gate.settings import GateSettings
    from reflexarc_sim_bridge.body.latch import StopLatch
    from reflexarc_sim_bridge.body.ros2.bridge import RosBridgeReport
    from reflexarc_sim_bridge.body.ros2.companion_link import CompanionLink
    from reflexarc_sim_bridge.body.ros2.route import Route

MAX_RATE_HZ = 1000.0
SILENCE_S = 0.2
"""Whoever holds the robot and says nothing for so long loses it: twice the age at which an input
is too old by default, as no policy tells a robot its own."""

NOT_A_CLIENT = """\
reflexarc ros2: --zenoh: expected mode "client" with --wire rmw: on another machine a peer hears \
the robot or not, by which Zenoh identifier is greater"""


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
      reflexarc ros2 --limits robot.toml --wire rmw --distribution humble --node robot1/reflex
    """

    topic: str = "scan"
    """The robot's topic of sensor_msgs/LaserScan."""
    command: str = "cmd_vel"
    """The topic that the robot drives by."""
    stamped: bool = False
    """Send geometry_msgs/TwistStamped in place of geometry_msgs/Twist."""
    stamp: Literal["scan", "wall", "zero"] = "scan"
    """With --stamped: the stamp of the scan that a motion came from; this machine's clock, which
    must be the robot's then; or none, which means now. A standstill has none with the first."""
    wire: Literal["ros2dds", "rmw"] = "ros2dds"
    """How ROS 2 meets Zenoh: by zenoh-plugin-ros2dds, or by rmw_zenoh."""
    domain: int = 0
    """ROS_DOMAIN_ID; it counts with rmw."""
    distribution: Literal["humble", "jazzy"] = "jazzy"
    """ROS distribution of the robot, with rmw: Humble has no type hashes, Iron and all later ones
    do as Jazzy."""
    node: str = "reflexarc"
    """Name of the bridge in the ROS graph, with rmw; robot1/reflex has a namespace."""
    odometry: str = "odom"
    """The robot's topic of nav_msgs/Odometry, passed on as `pose` for the log; empty: none."""
    tf: str = "tf"
    """Its topic of tf2_msgs/TFMessage, passed on as `tf`, and the one with _static behind it, which
    says how the scanner sits; empty: none."""
    base: str = "base_link"
    """The robot's own frame, from which x leads ahead."""
    rate: float = 50.0
    """Commands to the robot, a second, at least."""
    body: BodyFlags = field(default_factory=BodyFlags)
    ignore_scan_stamps: bool = False
    """Age counts from a scan's arrival alone: for simulators whose time runs slower than ours."""
    robot_limits: LimitFlags = field(default_factory=LimitFlags)
    scanner: ScanFlags = field(default_factory=ScanFlags)
    auto_arm: bool = False
    """Drive as soon as a runtime says so, without `reflexarc arm`."""
    hold_to_run: bool = False
    """Drive only while somebody holds a button: `reflexarc arm --hold`."""
    arm_each_runtime: bool = False
    """Let an arm count for one runtime: one that is started again must be armed again."""
    no_companion: bool = False
    """Go without the process that stops the robot if this one is killed or hangs."""
    state: Path = Path("runs")
    """Folder in which a stop is kept until its reset."""
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Serve until the end, then say what went over the bridge."""
        import reflexarc_sim_bridge.body.ros2.bridge  # noqa: F401  # a missing extra is said first
        from reflexarc_runtime.messages.topics import BODY_NODE

        route, settings = self._route(), self._settings()
        with StopFlag() as stop:
            client = route.wire.has_router
            bus = joined(self.joining, BODY_NODE, stop, "reflexarc ros2", client=client)
            if bus is None:
                return 0
            if client and not bus.is_client:
                aside.print(NOT_A_CLIENT)
            with bus:
                self.body.check_runtime(bus, stop, "reflexarc ros2")
                account = self._serve(bus, route, settings, stop)
        self._tell(account)
        return 0

    def _settings(self) -> "GateSettings":
        from reflexarc_sim_bridge.body.gate.settings import GateSettings

        limits = self.robot_limits.body_limits()
        return GateSettings(
            SILENCE_S,
            limits,
            auto_arm=self.auto_arm,
            hold_to_run=self.hold_to_run,
            arm_each_runtime=self.arm_each_runtime,
        )

    def _route(self) -> "Route":
        from reflexarc_sim_bridge.body.ros2.key_expressions import check_topic
        from reflexarc_sim_bridge.body.ros2.route import Route
        from reflexarc_sim_bridge.body.ros2.stamps import StampRule
        from reflexarc_sim_bridge.body.ros2.wires import wire_named

        if not 0.0 < self.rate <= MAX_RATE_HZ:
            raise UsageError(f"--rate: expected 0 to {MAX_RATE_HZ:g} Hz, got {self.rate}")
        if self.stamp != "scan" and not self.stamped:
            raise UsageError("--stamp: a geometry_msgs/Twist has no stamp; give --stamped as well")
        if not self.base:
            raise UsageError("--base: expected the name of the robot's own frame, got none")
        has_hashes = self.distribution != "humble"
        route = Route(
            wire_named(self.wire, self.domain, has_hashes=has_hashes, node=self.node),
            check_topic("--topic", self.topic),
            check_topic("--command", self.command),
            self.stamped,
            StampRule(self.stamp),
            self.odometry and check_topic("--odometry", self.odometry),
            self.tf and check_topic("--tf", self.tf),
            self.base,
            self._scanner(),
            not self.ignore_scan_stamps,
        )
        self._check_keys(route)
        return route

    def _check_keys(self, route: "Route") -> None:
        """Refuse keys of the robot that are ours as well: we would hear ourselves."""
        from reflexarc_runtime.messages.topics import TOPICS

        ours = {topic.key(self.joining.robot) for topic in TOPICS}
        for key in route.keys:
            if key in ours:
                raise UsageError(
                    f"{key}: expected the robot's keys and ours to differ; "
                    "give ours another first part with --robot"
                )

    def _scanner(self) -> "RosScanner":
        from reflexarc_runtime.ros2.laser_scan import RosScanner

        flags = self.scanner
        return RosScanner(flags.meaning, flags.known_mount, flags.ignored)

    def _serve(
        self, bus: "Bus", route: "Route", settings: "GateSettings", stop: StopFlag
    ) -> "RosBridgeReport":
        from reflexarc.wiring.waiting import Waiting
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
            with Waiting(bus, self._wish(route), lambda: bridge.hears_scans):
                return bridge.serve(turns, stop)

    def _wish(self, route: "Route") -> "Wish":
        """What is waited for, and what it might be that comes instead."""
        from reflexarc.wiring.waiting import Wish
        from reflexarc_runtime.ros2.ros_types import LASER_SCAN

        last = route.scan.rpartition("/")[2]
        advice = {
            LASER_SCAN.type_hash: "--wire rmw --domain {first}?",
            "TypeHashNotSupported": "--wire rmw --distribution humble --domain {first}?",
            f"/{last}": "--wire ros2dds --topic {key}?",
            last: "--wire ros2dds?",
        }
        return Wish("reflexarc ros2", "scans", route.scan_key, (f"**/{last}/**",), advice)

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
            odometry_key=route.odometry_key,
            stamp=self.stamp,
            client=route.wire.has_router,
            allow_open=self.joining.allow_open,
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
                    "poses": account.poses,
                    "transforms": account.transforms,
                    "refused places": _counts(account.refused_places),
                }
            )
        )


def _counts(reasons: dict[str, int]) -> str:
    return ", ".join(f"{count} {reason}" for reason, count in reasons.items()) or "none"
