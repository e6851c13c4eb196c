"""The bridge between a robot that speaks ROS 2 and our bus, where that robot is the body.

Scans are passed on as they come: their source time is the moment of arrival on this machine's
monotonic clock, which the command repeats; the header's own stamp stays in the message. Commands go
the other way at a fixed rate: at every tick a watchdog decides whether the last one still holds; if
not, the robot is told to stand. So a runtime that dies, a scanner that dies and a bus that
fails all stop the robot, within the command's validity and one tick.

A safe command names no input, so its age is unknown: here it means standstill, whatever its speeds.
"""

import logging
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Command
from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacer import Pacer
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.loop.watchdog import Watchdog
from reflexarc_runtime.messages.body_info import BodyInfo, encode_body
from reflexarc_runtime.messages.codec import Status, decode_command, encode_status
from reflexarc_runtime.messages.topics import BODY, BODY_NODE, COMMAND, SCAN, STATUS, Quality
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.limits import Twist
from reflexarc_sim_bridge.body.ros2.key_expressions import LASER_SCAN, TWIST, TWIST_STAMPED, RosType
from reflexarc_sim_bridge.body.ros2.messages import (
    UnusableMessageError,
    decode_scan,
    encode_scan,
    encode_twist,
    encode_twist_stamped,
)
from reflexarc_sim_bridge.body.ros2.wires import Wire

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus, Publisher

STANDSTILL = Action("stop", 0.0, 0.0)
COMMAND_FRAME = "base_link"
"""Frame of a stamped command: the robot's own (REP 105)."""

_CDR = "application/cdr"
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Route:
    """The topics of the robot, and how they are encoded on Zenoh."""

    wire: Wire
    scan: str
    """Full name of the topic of `sensor_msgs/LaserScan`."""
    command: str
    """Full name of the topic that the robot drives by."""
    stamped: bool = False
    """Whether that one takes `geometry_msgs/TwistStamped`, or `Twist`."""

    @property
    def command_type(self) -> RosType:
        """Type of the commands."""
        return TWIST_STAMPED if self.stamped else TWIST

    @property
    def scan_key(self) -> str:
        """Key of the scans."""
        return self.wire.key(self.scan, LASER_SCAN)

    @property
    def command_key(self) -> str:
        """Key of the commands."""
        return self.wire.key(self.command, self.command_type)

    def tokens(self, session_id: str) -> tuple[str, ...]:
        """Liveliness tokens by which we appear in the robot's ROS graph."""
        heard, spoken = (self.scan, LASER_SCAN), (self.command, self.command_type)
        return self.wire.tokens(session_id, heard, spoken)


@dataclass(frozen=True, slots=True)
class RosBridgeReport:
    """How many messages the bridge passed on or refused."""

    scans: int
    refused_scans: dict[str, int]
    """How many, by reason."""
    commands: int
    refused_commands: int
    twists: int
    standstills: int
    """How many of the twists told the robot to stand."""


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
    """

    def __init__(self, publisher: "Publisher") -> None:
        self._publisher = publisher
        self.scans = 0
        self.refused: Counter[str] = Counter()

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            payload = encode_scan(decode_scan(message.payload))
        except UnusableMessageError as error:
            self._refuse(str(error))
            return
        self.scans += 1
        self._publisher.put(payload, message.received_ns)

    def _refuse(self, reason: str) -> None:
        self.refused[reason] += 1
        if self.refused[reason] == 1:
            _LOG.warning("a scan of the robot is refused: %s (said once)", reason)


class CommandRelay:
    """Sends the robot, at every call, the last command if it still holds, else a standstill.

    Args:
        publisher: on the robot's wire.
        stamped: whether the robot takes stamped commands.
        wall_offset: what to add to `now_ns` to get the wall clock, by which ROS stamps.
    """

    def __init__(
        self, publisher: "Publisher", stamped: bool, wall_offset: Callable[[], int] = wall_offset_ns
    ) -> None:
        self._publisher = publisher
        self._stamped = stamped
        self._wall_offset = wall_offset
        self._watchdog = Watchdog(STANDSTILL)
        self.commands = self.refused = self.twists = self.standstills = 0

    def hear(self, message: Message) -> None:
        """Take a command; the newest counts."""
        command = decode_command(message.payload)
        if command is None or not _is_finite(command):
            self.refused += 1
            return
        self.commands += 1
        self._watchdog = self._watchdog.heard(command)

    def speak(self, now_ns: int) -> None:
        """Send the command that holds now, or a standstill."""
        obeyed = self._watchdog.obeyed(now_ns)
        self._send(STANDSTILL if obeyed is None or obeyed.is_safe else obeyed, now_ns)

    def stop(self, now_ns: int) -> None:
        """Send a standstill."""
        self._send(STANDSTILL, now_ns)

    def _send(self, motion: Twist, now_ns: int) -> None:
        wall_ns = now_ns + self._wall_offset()
        self._publisher.put(self._encode(motion, wall_ns), wall_ns)
        self.twists += 1
        self.standstills += motion is STANDSTILL

    def _encode(self, motion: Twist, wall_ns: int) -> bytes:
        if self._stamped:
            return encode_twist_stamped(motion, wall_ns, COMMAND_FRAME)
        return encode_twist(motion)


class RosBridge:
    """Connects a robot that speaks ROS 2 to our bus.

    Args:
        bus: an open session that reaches both.
        route: the robot's side.
        inbox: where the bus delivers our commands.
    """

    def __init__(self, bus: "Bus", route: Route, inbox: Inbox) -> None:
        self._scans = ScanRelay(bus.publisher(SCAN))
        wheel = bus.publisher_of_key(route.command_key, _CDR, Quality.CONTROL)
        self._commands = CommandRelay(wheel, route.stamped)
        self._status, self._info = bus.publisher(STATUS), bus.publisher(BODY)
        self._every_second = Throttle()
        for token in route.tokens(bus.session_id):
            bus.announce_key(token)
        bus.subscribe([COMMAND], inbox.put)
        bus.subscribe_to_key(route.scan_key, self._scans.hear)
        bus.announce(BODY_NODE)

    def serve(self, pacer: Pacer, should_stop: Callable[[], bool]) -> RosBridgeReport:
        """Serve until asked to stop; the robot's last command is to stand."""
        try:
            while (wakeup := pacer.wait(should_stop)) is not None:
                for message in wakeup.messages:
                    self._commands.hear(message)
                self._commands.speak(wakeup.now_ns)
                self._say_every_second(wakeup.now_ns)
        finally:
            self._commands.stop(pacer.now_ns())
        return self.account

    @property
    def account(self) -> RosBridgeReport:
        """The counts until now."""
        return RosBridgeReport(
            scans=self._scans.scans,
            refused_scans=dict(self._scans.refused),
            commands=self._commands.commands,
            refused_commands=self._commands.refused,
            twists=self._commands.twists,
            standstills=self._commands.standstills,
        )

    def _say_every_second(self, now_ns: int) -> None:
        if not self._every_second.is_due(now_ns):
            return
        status = Status(node=BODY_NODE, ticks=self._commands.twists)
        self._status.put(encode_status(status), now_ns)
        self._info.put(encode_body(BodyInfo()), now_ns)


def _is_finite(command: Command) -> bool:
    speeds = (command.linear_mps, command.lateral_mps, command.angular_radps)
    return all(map(math.isfinite, speeds))
