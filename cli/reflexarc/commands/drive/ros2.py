"""`reflexarc ros2`: a robot that speaks ROS 2 over Zenoh becomes the body."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from reflexarc.terminal.output import aside, console, facts, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_sim_bridge.body.ros2.bridge import RosBridgeReport, Route

MAX_RATE_HZ = 1000.0


@dataclass(frozen=True)
class Ros2Command:
    """Connect a robot that speaks ROS 2 over Zenoh: scans in, velocity commands out.

    It joins where the robot's own Zenoh router listens (--port, 7447 for rmw_zenohd and
    zenoh-bridge-ros2dds), and so does `reflexarc run --input scan`. While no command is valid it
    tells the robot, --rate times a second, to stand. No ROS is needed on this machine.

    Examples:
      reflexarc ros2
      reflexarc ros2 --wire rmw --domain 7 --stamped
      reflexarc ros2 --topic robot1/scan --command robot1/cmd_vel --zenoh robot.json5
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
    """Commands to the robot, a second."""
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Serve until the end, then say what went over the bridge."""
        from reflexarc_runtime.messages.topics import BODY_NODE

        route = self._route()
        with StopFlag() as stop, self.joining.bus(BODY_NODE) as bus:
            account = self._serve(bus, route, stop)
        self._tell(account)
        return 0

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
        )
        for key in (SCAN.key(self.joining.robot), COMMAND.key(self.joining.robot)):
            if key in (route.scan_key, route.command_key):
                raise UsageError(
                    f"{key}: expected the robot's keys and ours to differ; "
                    "give ours another first part with --robot"
                )
        return route

    def _serve(self, bus: "Bus", route: "Route", stop: StopFlag) -> "RosBridgeReport":
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.inbox import Inbox
        from reflexarc_runtime.loop.pacer import RatePacer
        from reflexarc_sim_bridge.body.ros2.bridge import RosBridge

        inbox = Inbox()
        bridge = RosBridge(bus, route, inbox)
        aside.print(
            f"reflexarc ros2: {route.scan} → {route.command} on {self.wire}, {self.rate:g} Hz"
        )
        return bridge.serve(RatePacer(self.rate, MonotonicClock(), inbox), stop)

    def _tell(self, account: "RosBridgeReport") -> None:
        if self.json:
            print_json(account)
            return
        refused = ", ".join(f"{count} {reason}" for reason, count in account.refused_scans.items())
        console.print(
            facts(
                {
                    "scans": account.scans,
                    "refused scans": refused or "none",
                    "commands": f"{account.commands}, {account.refused_commands} refused",
                    "twists": f"{account.twists}, {account.standstills} of them standstill",
                }
            )
        )
