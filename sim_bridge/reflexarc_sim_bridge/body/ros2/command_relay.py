"""Our commands, passed on to the robot through the gate, which has the last word on each.

A command that the gate takes goes out at once; at the latest after a period the robot is told again
what holds now, which is standstill unless a command is still valid. A safe command names no input,
so its age is unknown: here it means standstill, whatever its speeds.
"""

from collections.abc import Iterable

from reflexarc_runtime.messages.topics import COMMAND, topic_of
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.account import Account
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.latch import StopLatch
from reflexarc_sim_bridge.body.ros2.twists import TwistPublisher


class CommandRelay:
    """Tells the robot what the gate lets through.

    Args:
        twists: to the robot.
        gate: as it is before anything was heard.
        latch: keeps a stop that outlives the bridge; without one, a stop ends with it.
    """

    def __init__(self, twists: TwistPublisher, gate: Gate, latch: StopLatch | None = None) -> None:
        self._twists = twists
        self._gate = gate
        self._latch = latch
        self._spoke_ns: int | None = None
        self.heard = self.standstills = 0

    def begin(self, now_ns: int) -> None:
        """From now on a button that is pressed counts."""
        self._gate = self._gate.begun(now_ns)

    @property
    def twists(self) -> int:
        """How many were sent."""
        return self._twists.count

    @property
    def account(self) -> Account:
        """Whom the gate obeys, and what it refused."""
        return self._gate.lease

    def hear(self, messages: Iterable[Message]) -> bool:
        """Take messages, oldest first; whether one of them changes what holds."""
        wanted = self._gate.wanted
        for message in messages:
            self._gate = self._gate.hear(message, message.received_ns)
            self.heard += topic_of(message.key) is COMMAND
        return self._gate.wanted is not wanted

    def speak(self, now_ns: int) -> None:
        """Tell the robot what holds now."""
        since_ns = 0 if self._spoke_ns is None else now_ns - self._spoke_ns
        motion, self._gate = self._gate.obey(now_ns, since_ns * 1e-9)
        wanted = None if motion.stands else self._gate.wanted
        self._send(motion, now_ns, None if wanted is None else wanted.source_time_ns)
        if self._latch is not None:  # after the twist: a disk may be slow
            self._latch.keep(self._gate.stopped)

    def stop(self, now_ns: int) -> None:
        """Tell it to stand."""
        self._send(STANDSTILL, now_ns)

    def _send(self, motion: Motion, now_ns: int, source_ns: int | None = None) -> None:
        self._twists.send(motion, now_ns, source_ns)
        self._spoke_ns = now_ns
        self.standstills += motion.stands
