"""The bridge between a body and the bus, in real time or in lockstep.

In real time the body moves at its own rate, obeys a command while it is valid, and publishes what
it sees, without waiting. In lockstep it waits for the command of each retina, and time is counted
in steps: the same drive on any machine, under any load.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.lockstep import await_command, wait_for_runtime
from reflexarc_runtime.loop.pacer import RatePacer
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.body_info import encode_body
from reflexarc_runtime.messages.codec import (
    Status,
    decode_command,
    encode_contact,
    encode_retina,
    encode_status,
)
from reflexarc_runtime.messages.topics import (
    BODY,
    BODY_NODE,
    COMMAND,
    CONTACT,
    POSE,
    RETINA,
    RUNTIME_NODE,
    SCENE,
    STATUS,
    TRANSFORM,
    Topic,
)
from reflexarc_sim_bridge.body.body import Body, BodyPose
from reflexarc_sim_bridge.body.faults.delayed_sender import DelayedSender
from reflexarc_sim_bridge.body.faults.faulty_stream import Sending
from reflexarc_sim_bridge.body.faults.script import FaultScript
from reflexarc_sim_bridge.body.foxglove_messages import encode_pose, encode_scene, encode_transform

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

_PUBLISHED = (RETINA, POSE, TRANSFORM, SCENE, CONTACT, BODY, STATUS)


@dataclass(frozen=True, slots=True)
class Journey:
    """Length and contacts of a drive."""

    steps: int
    contacts: int
    distance_m: float


class RetinaOutlet(Protocol):
    """Publishes retinas."""

    def put(self, payload: bytes, time_ns: int) -> None:
        """Publish a retina that was seen at `time_ns`; never blocks."""
        ...


def faulty_retinas(bus: "Bus", script: FaultScript, now_ns: Callable[[], int]) -> DelayedSender:
    """A publisher of retinas with the faults of a script; a context manager."""
    publisher = bus.publisher(RETINA)

    def send(sending: Sending) -> None:
        publisher.put_raw(sending.payload, sending.attachment, sending.encoding)

    return DelayedSender(script, send, now_ns)


class StatePublisher:
    """Publishes what a body sees and where it is."""

    def __init__(
        self, bus: "Bus", body: Body, robot: str, retinas: RetinaOutlet | None = None
    ) -> None:
        self._publishers = {topic: bus.publisher(topic) for topic in _PUBLISHED}
        self._retinas = retinas or self._publishers[RETINA]
        self._body = body
        self._robot = robot
        self._info = encode_body(body.info)
        self._steps = 0
        self._every_second = Throttle()

    def has_listener(self, topic: Topic) -> bool:
        """Whether anyone listens to a topic."""
        return self._publishers[topic].has_listener

    def publish(self, contact: BodyPose | None, now_ns: int) -> None:
        """Publish the state of the body: the retina first, because the runtime waits for it."""
        retina = encode_retina(self._body.see(), self._body.contract.retina, now_ns, self._robot)
        self._retinas.put(retina, now_ns)
        place = self._body.place
        self._publishers[POSE].put(encode_pose(place, now_ns), now_ns)
        self._publishers[TRANSFORM].put(encode_transform(place, self._robot, now_ns), now_ns)
        if contact is not None:
            payload = encode_contact(self._body.contacts, contact.x_m, contact.y_m, now_ns)
            self._publishers[CONTACT].put(payload, now_ns)
        self._steps += 1
        self._publish_every_second(now_ns)

    def _publish_every_second(self, now_ns: int) -> None:
        if not self._every_second.is_due(now_ns):
            return
        # Again and again: a recorder that joins later shall know where it is, too.
        self._publishers[BODY].put(self._info, now_ns)
        near = self._body.simulation.outlines_near(0)
        self._publishers[SCENE].put(encode_scene(near, now_ns), now_ns)
        status = Status(node=BODY_NODE, ticks=self._steps, guard=self._body.guard_state)
        self._publishers[STATUS].put(encode_status(status), now_ns)


class Bridge:
    """Connects a body to the bus.

    Args:
        bus: an open session.
        body: the robot.
        robot: first part of every key.
        inbox: where the bus delivers the commands.
        retinas: where the retinas go; straight to the bus by default.
    """

    def __init__(
        self, bus: "Bus", body: Body, robot: str, inbox: Inbox, retinas: RetinaOutlet | None = None
    ) -> None:
        self._bus = bus
        self._body = body
        self._inbox = inbox
        self._publisher = StatePublisher(bus, body, robot, retinas)
        bus.subscribe([COMMAND], inbox.put)
        bus.announce(BODY_NODE)

    def drive(
        self, pacer: RatePacer, should_stop: Callable[[], bool], steps: int | None = None
    ) -> Journey:
        """Drive in real time, until asked to stop or for a number of steps."""
        done = 0
        while steps is None or done < steps:
            wakeup = pacer.wait(should_stop)
            if wakeup is None:
                break
            for message in wakeup.messages:
                command = decode_command(message.payload)
                if command is not None:
                    self._body.hear(command)
            self._publisher.publish(self._body.move(wakeup.now_ns), wakeup.now_ns)
            done += 1
        return self._journey(done)

    def drive_in_lockstep(
        self, period_ns: int, should_stop: Callable[[], bool], steps: int | None = None
    ) -> Journey:
        """Drive one step for each command; the time is that of the step.

        Raises:
            BusError: no command came for a retina.
        """
        wait_for_runtime(self._inbox, self._runtime_is_ready, should_stop)
        done, contact = 0, None
        while not should_stop() and (steps is None or done < steps):
            now_ns = done * period_ns
            self._publisher.publish(contact, now_ns)
            await_command(self._inbox, done, self._body.hear, should_stop)
            contact = self._body.move(now_ns)
            done += 1
        return self._journey(done)

    def _runtime_is_ready(self) -> bool:
        return self._publisher.has_listener(RETINA) and self._bus.is_alive(RUNTIME_NODE)

    def _journey(self, steps: int) -> Journey:
        distance_m = float(self._body.simulation.distance_m[0])
        return Journey(steps, self._body.contacts, distance_m)
