"""The companion of a bridge: a process of its own that listens to the bridge's twists.

Whatever ends a bridge from inside, it says standstill itself. What ends it from outside (SIGKILL,
SIGSTOP, a hang, an empty memory) leaves it no word. The companion has a session of its own to the
robot's router and a process session of its own, so that a signal to the bridge's group or terminal
does not reach it. Three things end it: the bridge's farewell; the end of the pipe between them
(the bridge is gone), once the robot was told to stand for long enough; and a signal of its own.

    python -m reflexarc_sim_bridge.body.ros2.companion '{"command_key": "cmd_vel", …}'
"""

import json
import logging
import os
import select
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.loop.clock import wall_offset_ns
from reflexarc_runtime.messages.topics import Quality
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL
from reflexarc_sim_bridge.body.ros2.silence import BridgeSilence
from reflexarc_sim_bridge.body.ros2.stamps import Stamper, StampRule
from reflexarc_sim_bridge.body.ros2.standing import Standing
from reflexarc_sim_bridge.body.ros2.twists import CDR, TwistPublisher, moves

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

READY = b"ready\n"
"""What it says to the bridge when it listens."""
FAREWELL = b"farewell\n"
"""What the bridge says to it after its own last standstill."""

NICENESS = -15
"""Before all ordinary processes, behind those of real time."""

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Watched:
    """Whose twists a companion listens to, and where."""

    robot: str
    port: int
    zenoh: str
    """Zenoh's configuration; empty: the loopback."""
    command_key: str
    stamped: bool
    sender: str
    """The bridge's identifier, in hexadecimal: only its own twists are signs of its life."""
    period_ns: int
    """The longest time between two of them."""
    odometry_key: str = ""
    """Where the robot says how fast it is; empty: nowhere."""
    stamp: str = StampRule.SCAN
    """What they are stamped with: a value of `StampRule`."""
    client: bool = False
    """Whether the bridge is a client of the robot's router."""
    allow_open: bool = False
    """Whether the Zenoh configuration may let in strangers."""

    @property
    def stamper(self) -> Stamper | None:
        """How a standstill is stamped, for which no scan is needed; None: not at all."""
        return Stamper(StampRule(self.stamp), wall_offset_ns) if self.stamped else None

    @property
    def bus(self) -> BusConfig:
        """How to reach the robot's router."""
        zenoh = Path(self.zenoh) if self.zenoh else None
        return BusConfig(
            self.robot,
            self.port,
            zenoh_file=zenoh,
            client=self.client,
            allow_open=self.allow_open,
        )

    def text(self) -> str:
        """As an argument of a command line."""
        return json.dumps(asdict(self))


class Door(Protocol):
    """The pipe from the bridge."""

    def wait(self, until_ns: int) -> bytes | None:
        """What the bridge said; None: nothing until then; empty: it has ended."""
        ...


class Pipe:
    """The companion's standard input, whose other end the bridge holds for as long as it lives."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._is_open = True

    def wait(self, until_ns: int) -> bytes | None:
        """See `Door.wait`."""
        left_s = max(0.0, (until_ns - time.monotonic_ns()) * 1e-9)
        if not self._is_open:
            time.sleep(left_s)
            return None
        if not select.select([self._descriptor], [], [], left_s)[0]:
            return None
        said = os.read(self._descriptor, len(FAREWELL))
        self._is_open = bool(said)
        return said


class Companion:
    """Says standstill in place of a bridge that has fallen silent.

    Args:
        bus: a session of its own.
        watched: the bridge.
        now_ns: the clock by which the bus says when a message arrived.
    """

    def __init__(self, bus: "Bus", watched: Watched, now_ns: Callable[[], int]) -> None:
        publisher = bus.publisher_of_key(watched.command_key, CDR, Quality.CONTROL)
        self._twists = TwistPublisher(publisher, watched.stamper, wall_offset_ns)
        self._sender = bytes.fromhex(watched.sender)
        self._period_ns = watched.period_ns
        self._silence = BridgeSilence(watched.period_ns)
        self._turn = threading.Lock()  # a thread of the bus and the main one come here
        self._now_ns = now_ns
        self._speaks = self._overslept = False
        self._standing = Standing()
        bus.subscribe_to_key(watched.command_key, self.hear)
        if watched.odometry_key:
            bus.subscribe_to_key(watched.odometry_key, self.feel)

    @property
    def standstills(self) -> int:
        """How often it told the robot to stand."""
        return self._twists.count

    def hear(self, message: Message) -> None:
        """Take a twist; called on a thread of the bus. Only the bridge's own ones count."""
        try:
            sender = unpack_stamp(message.attachment).sender
        except UndecodableError:
            return
        if sender == self._sender:
            moving = moves(message.payload)
            with self._turn:
                self._silence = self._silence.heard(message.received_ns, moving)

    def feel(self, message: Message) -> None:
        """Take what the robot says of its speed; called on a thread of the bus."""
        self._standing = self._standing.heard(message.payload, message.received_ns)

    def watch(self, door: Door) -> None:
        """Watch until the bridge says farewell, or is gone and the robot was told to stand."""
        is_gone = False
        while not is_gone or self._silence.must_speak(self._now_ns(), is_gone):
            look_ns = self._next_look_ns()
            said = None if is_gone else door.wait(look_ns)
            if said == FAREWELL:
                return
            is_gone = is_gone or said == b""
            self._look(look_ns, is_gone)
            if is_gone:
                door.wait(self._now_ns() + self._period_ns)

    def _next_look_ns(self) -> int:
        """When to look; soon after an oversleep, as the bridge may be silent for longer already."""
        now_ns = self._now_ns()
        return now_ns + self._period_ns // 4 if self._overslept else self._silence.look_ns(now_ns)

    def _look(self, planned_ns: int, is_gone: bool) -> None:
        """Say standstill if the bridge does not speak."""
        late_ns = self._now_ns() - planned_ns
        self._overslept = late_ns > self._period_ns and not is_gone and not self._overslept
        if self._overslept:
            return  # what the bridge said meanwhile may still be on its way
        must_speak = self._silence.must_speak(self._now_ns(), is_gone)
        if must_speak and self._standing.is_sure(self._now_ns()):
            with self._turn:  # a twist that moves may come meanwhile
                self._silence = self._silence.stood(self._now_ns())
        if must_speak:
            self._twists.send(STANDSTILL, self._now_ns())
        if must_speak and not self._speaks:
            # A terminal that nobody reads blocks whoever writes: not the one that says standstill.
            threading.Thread(target=_say_silent, daemon=True).start()
        self._speaks = must_speak


def _say_silent() -> None:
    _LOG.warning("the bridge is silent: its companion tells the robot to stand")


def hurry() -> bool:
    """Ask for the processor before others, if allowed: a bridge that hangs may use a whole one.

    The companion itself needs next to nothing of it.
    """
    try:
        os.setpriority(os.PRIO_PROCESS, 0, NICENESS)
    except OSError:
        return False
    return True


def main() -> None:
    """Watch the bridge that the first argument tells of."""
    hurry()
    logging.basicConfig(format="reflexarc: %(message)s", level=logging.WARNING)
    try:
        _watch(fill(Watched, MappingSource(json.loads(sys.argv[1]))))
    except ReflexarcError as error:
        sys.exit(f"reflexarc: {error}")


def _watch(watched: Watched) -> None:
    from reflexarc_runtime.bus import Bus

    with Bus(watched.bus, time.monotonic_ns) as bus:
        companion = Companion(bus, watched, time.monotonic_ns)
        sys.stdout.buffer.write(READY)
        sys.stdout.flush()
        companion.watch(Pipe(sys.stdin.fileno()))


if __name__ == "__main__":
    main()
