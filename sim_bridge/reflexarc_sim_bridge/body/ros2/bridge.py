"""The bridge between a robot that speaks ROS 2 and our bus, where that robot is the body.

Scans are passed on as they come: their source time is the moment of arrival on this machine's
monotonic clock, less what they waited before it, which the command repeats; the header's own stamp
stays in the message. Commands go
the other way through the gate, when they arrive and at the latest at a fixed period: what no longer
holds becomes a standstill. So a runtime that dies, a scanner that dies and a bus that fails all
stop the robot, within the command's validity and one period.

Whatever ends the bridge from inside, its last words are standstill, said ten times: one alone may
be lost on the way. What ends it from outside is its companion's business (companion.py).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.body_info import BodyInfo, encode_body
from reflexarc_runtime.messages.codec import Status, encode_status
from reflexarc_runtime.messages.topics import (
    BODY,
    BODY_NODE,
    COMMAND,
    LEASE,
    SCAN,
    STATUS,
    Quality,
)
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.gate import HEARD, Gate, GateSettings, encode_lease
from reflexarc_sim_bridge.body.latch import StopLatch
from reflexarc_sim_bridge.body.ros2.command_relay import CommandRelay
from reflexarc_sim_bridge.body.ros2.key_expressions import LASER_SCAN, TWIST, TWIST_STAMPED, RosType
from reflexarc_sim_bridge.body.ros2.messages import STANDARD, RosScanner
from reflexarc_sim_bridge.body.ros2.scan_relay import ScanRelay
from reflexarc_sim_bridge.body.ros2.turns import Turns
from reflexarc_sim_bridge.body.ros2.twists import CDR, TwistPublisher
from reflexarc_sim_bridge.body.ros2.wires import Wire

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

FAREWELLS = 10
"""Standstills at the end."""
FAREWELL_STEP_NS = 20_000_000
"""Time between two of them; the last one leaves the bus time to send it."""
NO_COMPANION = "nobody watches the twists"
"""Under this name the status counts the seconds without a companion."""


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
    scanner: RosScanner = STANDARD
    """What is known of the scanner beside what its messages say."""
    heeds_stamps: bool = True
    """Whether the stamps of scans tell how old they are."""

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
    """How many came, from whomever."""
    refused_commands: dict[str, int]
    """How many messages were refused or slowed down, by reason."""
    twists: int
    standstills: int
    """How many of the twists told the robot to stand."""


class Watcher(Protocol):
    """Somebody who stops the robot when the bridge cannot."""

    def is_alive(self) -> bool:
        """Whether it is there."""
        ...


class RosBridge:
    """Connects a robot that speaks ROS 2 to our bus.

    Args:
        bus: an open session that reaches both.
        route: the robot's side.
        inbox: where the bus delivers what is said to the body.
        settings: of the gate: the robot's limits, whether it is armed.
        watcher: the bridge's companion, if it has one.
        latch: keeps a stop that outlives the bridge.
    """

    def __init__(
        self,
        bus: "Bus",
        route: Route,
        inbox: Inbox,
        settings: GateSettings,
        watcher: Watcher | None = None,
        latch: StopLatch | None = None,
    ) -> None:
        self._inbox = inbox
        # A flood of commands must not push a stop out of a full inbox.
        self._controls = Inbox()
        self._scans = ScanRelay(bus.publisher(SCAN), route.scanner, heeds_stamps=route.heeds_stamps)
        wheel = bus.publisher_of_key(route.command_key, CDR, Quality.CONTROL)
        twists = TwistPublisher(wheel, route.stamped, wall_offset_ns)
        gate = Gate.closed(bus.sender, settings, latch.stopped if latch else "")
        self._commands = CommandRelay(twists, gate, latch)
        self._speaker = _Speaker(bus, settings, watcher)
        for token in route.tokens(bus.session_id):
            bus.announce_key(token)
        bus.subscribe([COMMAND], inbox.put)
        bus.subscribe([topic for topic in HEARD if topic is not COMMAND], self._hear_control)
        bus.subscribe_to_key(route.scan_key, self._scans.hear)
        bus.announce(BODY_NODE)

    def serve(self, turns: Turns, should_stop: Callable[[], bool]) -> RosBridgeReport:
        """Serve until asked to stop; the robot's last commands are to stand."""
        try:
            while (turn := turns.wait(should_stop)) is not None:
                controls, _ = self._controls.drain(turns.now_ns)
                has_news = self._commands.hear((*controls, *turn.messages))
                if has_news or turn.is_due:
                    self._commands.speak(turn.now_ns)
                    turns.spoke(turn.now_ns)
                self._speaker.say(self._commands, turn.now_ns)
        finally:
            self._take_leave(turns)
        return self.report

    @property
    def report(self) -> RosBridgeReport:
        """The counts until now."""
        return RosBridgeReport(
            scans=self._scans.scans,
            refused_scans=dict(self._scans.refused),
            commands=self._commands.heard,
            refused_commands=dict(self._commands.account.refused),
            twists=self._commands.twists,
            standstills=self._commands.standstills,
        )

    def _hear_control(self, message: Message) -> None:
        self._controls.put(message)
        self._inbox.put(_wake(message.received_ns))

    def _take_leave(self, turns: Turns) -> None:
        now_ns = turns.now_ns()
        for _ in range(FAREWELLS):
            self._commands.stop(now_ns)
            now_ns = turns.rest(FAREWELL_STEP_NS)


def _wake(now_ns: int) -> Message:
    """A message of no topic: it ends the waiting, and changes nothing."""
    return Message("", b"", "", b"", now_ns)


class _Speaker:
    """Says on our bus whom the robot obeys: at once when it changes, all of it once a second."""

    def __init__(self, bus: "Bus", settings: GateSettings, watcher: Watcher | None) -> None:
        self._status, self._info = bus.publisher(STATUS), bus.publisher(BODY)
        self._lease = bus.publisher(LEASE)
        self._body = encode_body(BodyInfo(limits=settings.limits))
        self._watcher = watcher
        self._unwatched_s = 0
        self._every_second = Throttle()
        self._news: object = None

    def say(self, commands: CommandRelay, now_ns: int) -> None:
        """Say what is due."""
        account = commands.account
        is_due = self._every_second.is_due(now_ns)
        if is_due or account.news != self._news:
            self._lease.put(encode_lease(account), now_ns)
            self._news = account.news
        if is_due:
            self._unwatched_s += self._watcher is None or not self._watcher.is_alive()
            counts = (*account.refused, (NO_COMPANION, self._unwatched_s))
            status = Status(node=BODY_NODE, ticks=commands.twists, verdicts=counts)
            self._status.put(encode_status(status), now_ns)
            self._info.put(self._body, now_ns)
