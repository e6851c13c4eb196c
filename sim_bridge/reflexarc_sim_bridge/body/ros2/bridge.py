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
from functools import partial
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.body_info import BodyInfo, encode_body
from reflexarc_runtime.messages.codec import Status, encode_status, encode_warning
from reflexarc_runtime.messages.topics import (
    BODY,
    BODY_NODE,
    COMMAND,
    LEASE,
    LOG,
    POSE,
    SCAN,
    STATUS,
    STOP,
    TRANSFORM,
    Quality,
)
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.ros2.mounts import Mounts
from reflexarc_runtime.ros2.ros_types import ODOMETRY, TF_MESSAGE
from reflexarc_sim_bridge.body.gate.account import SAID_EVERY_NS, encode_lease
from reflexarc_sim_bridge.body.gate.gate import HEARD, Gate
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from reflexarc_sim_bridge.body.latch import StopLatch
from reflexarc_sim_bridge.body.ros2.command_relay import CommandRelay
from reflexarc_sim_bridge.body.ros2.key_expressions import rmw_history_key
from reflexarc_sim_bridge.body.ros2.place_relay import PoseRelay, TransformRelay
from reflexarc_sim_bridge.body.ros2.route import Route
from reflexarc_sim_bridge.body.ros2.scan_relay import ScanRelay
from reflexarc_sim_bridge.body.ros2.stamps import ScanStamps, Stamper
from reflexarc_sim_bridge.body.ros2.turns import Turns
from reflexarc_sim_bridge.body.ros2.twists import CDR, TwistPublisher

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

FAREWELLS = 10
"""Standstills at the end."""
FAREWELL_STEP_NS = 20_000_000
"""Time between two of them; the last one leaves the bus time to send it."""
COMPANION_LOST = "the bridge's companion has ended: nobody watches the twists"
"""What the robot's log says when it is missed first."""
NO_COMPANION = "nobody watches the twists"
"""Under this name the status counts the seconds without a companion."""


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
    poses: int
    """How many of the robot's own reached our bus."""
    transforms: int
    refused_places: dict[str, int]
    """Odometry and transforms that were not passed on, by reason."""


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
        # A flood of commands, or of anything else, must not push a stop out of a full inbox.
        self._controls, self._stops = Inbox(), Inbox()
        stamps, mounts = ScanStamps(), Mounts(route.base) if route.tf else None
        heeds = route.heeds_stamps
        self._scans = ScanRelay(
            bus.publisher(SCAN), stamps, route.scanner, mounts, heeds_stamps=heeds
        )
        self._places = _Places(bus, route, mounts)
        wheel = bus.publisher_of_key(route.command_key, CDR, Quality.CONTROL)
        stamper = Stamper(route.stamp, wall_offset_ns, stamps) if route.stamped else None
        twists = TwistPublisher(wheel, stamper, wall_offset_ns)
        gate = Gate.closed(bus.sender, settings, latch.stopped if latch else "")
        self._commands = CommandRelay(twists, gate, latch)
        self._speaker = _Speaker(bus, settings, watcher)
        for token in route.tokens(bus.session_id):
            bus.announce_key(token)
        bus.subscribe([COMMAND], inbox.put)
        bus.subscribe([STOP], partial(self._hear_control, self._stops))
        others = [topic for topic in HEARD if topic not in (COMMAND, STOP)]
        bus.subscribe(others, partial(self._hear_control, self._controls))
        bus.subscribe_to_key(route.scan_key, self._scans.hear)
        bus.announce(BODY_NODE)

    @property
    def hears_scans(self) -> bool:
        """Whether anything has come on the topic of the scans."""
        return bool(self._scans.scans or self._scans.refused)

    def serve(self, turns: Turns, should_stop: Callable[[], bool]) -> RosBridgeReport:
        """Serve until asked to stop; the robot's last commands are to stand."""
        self._commands.begin(turns.now_ns())
        try:
            while (turn := turns.wait(should_stop)) is not None:
                controls, _ = self._controls.drain(turns.now_ns)
                stops, _ = self._stops.drain(turns.now_ns)
                # Stops behind what else was said: of a stop and a reset in one turn the stop holds.
                has_news = self._commands.hear((*controls, *stops, *turn.messages))
                if has_news or turn.is_due:
                    self._commands.speak(turn.now_ns)
                    turns.spoke(turn.now_ns)
                self._speaker.say(self._commands, turn.now_ns)
                self._places.transforms.repeat(turn.now_ns)
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
            poses=self._places.poses.poses,
            transforms=self._places.transforms.transforms,
            refused_places=self._places.refused,
        )

    def _hear_control(self, inbox: Inbox, message: Message) -> None:
        inbox.put(message)
        self._inbox.put(_wake(message.received_ns))

    def _take_leave(self, turns: Turns) -> None:
        now_ns = turns.now_ns()
        for _ in range(FAREWELLS):
            self._commands.stop(now_ns)
            now_ns = turns.rest(FAREWELL_STEP_NS)


def _wake(now_ns: int) -> Message:
    """A message of no topic: it ends the waiting, and changes nothing."""
    return Message("", b"", "", b"", now_ns)


class _Places:
    """Where the robot says that it is, for the log; and how its frames are, for its scanner."""

    def __init__(self, bus: "Bus", route: Route, mounts: Mounts | None) -> None:
        self.poses = PoseRelay(bus.publisher(POSE))
        self.transforms = TransformRelay(bus.publisher(TRANSFORM), mounts)
        if route.odometry:
            bus.subscribe_to_key(route.wire.key(route.odometry, ODOMETRY), self.poses.hear)
        if route.tf:
            static_key = route.wire.key(route.tf_static, TF_MESSAGE)
            bus.subscribe_to_key(route.wire.key(route.tf, TF_MESSAGE), self.transforms.hear)
            bus.subscribe_to_key(static_key, self.transforms.hear_static)
            bus.ask(rmw_history_key(static_key), self.transforms.hear_static)

    @property
    def refused(self) -> dict[str, int]:
        """What was not passed on, by reason."""
        return dict(self.poses.refusals.counts + self.transforms.refusals.counts)


class _Speaker:
    """Says on our bus whom the robot obeys: at once when it changes, all of it again and again."""

    def __init__(self, bus: "Bus", settings: GateSettings, watcher: Watcher | None) -> None:
        self._status, self._info = bus.publisher(STATUS), bus.publisher(BODY)
        self._lease = bus.publisher(LEASE)
        self._body = encode_body(BodyInfo(limits=settings.limits))
        self._log = bus.publisher(LOG)
        self._watcher = watcher
        self._unwatched_s = 0
        self._missed = False
        self._every_second, self._lease_period = Throttle(), Throttle(SAID_EVERY_NS)
        self._news: object = None

    def say(self, commands: CommandRelay, now_ns: int) -> None:
        """Say what is due."""
        account = commands.account
        if self._lease_period.is_due(now_ns) or account.news != self._news:
            self._lease.put(encode_lease(account), now_ns)
            self._news = account.news
        if self._every_second.is_due(now_ns):
            self._look_for_watcher(now_ns)
            counts = (*account.refused, (NO_COMPANION, self._unwatched_s))
            status = Status(node=BODY_NODE, ticks=commands.twists, verdicts=counts)
            self._status.put(encode_status(status), now_ns)
            self._info.put(self._body, now_ns)

    def _look_for_watcher(self, now_ns: int) -> None:
        """Count a second without a companion; say on our bus, too, that it was lost."""
        watcher = self._watcher
        if watcher is not None and watcher.is_alive():
            return
        self._unwatched_s += 1
        if watcher is not None and not self._missed:
            self._missed = True
            self._log.put(encode_warning(COMPANION_LOST, BODY_NODE, now_ns), now_ns)
