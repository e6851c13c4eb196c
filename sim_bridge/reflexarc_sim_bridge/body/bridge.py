"""The bridge between a body and the bus, in real time or in lockstep.

In real time the body moves at its own rate, does what its gate lets through, and publishes what it
sees, without waiting. In lockstep it waits for the command of each retina, and time is counted in
steps: the same drive on any machine, under any load.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.lockstep import await_command, wait_for_runtime
from reflexarc_runtime.loop.notices.flood_notice import FloodNotice
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.body_info import encode_body
from reflexarc_runtime.messages.codec import (
    Status,
    encode_contact,
    encode_retina,
    encode_status,
)
from reflexarc_runtime.messages.topics import (
    BODY,
    BODY_NODE,
    COMMAND,
    CONTACT,
    LEASE,
    POSE,
    RETINA,
    RUNTIME_NODE,
    SCENE,
    STATUS,
    STOP,
    TRANSFORM,
    Topic,
)
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.body import Body, BodyPose
from reflexarc_sim_bridge.body.faults.delayed_sender import DelayedSender
from reflexarc_sim_bridge.body.faults.faulty_stream import Sending
from reflexarc_sim_bridge.body.faults.script import FaultScript
from reflexarc_sim_bridge.body.following import Following
from reflexarc_sim_bridge.body.foxglove_messages import encode_pose, encode_scene, encode_transform
from reflexarc_sim_bridge.body.gate.account import SAID_EVERY_NS, Account, encode_lease
from reflexarc_sim_bridge.body.gate.gate import HEARD, Gate
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from reflexarc_sim_bridge.body.latch import StopLatch

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

TRANSFORM_EVERY_NS = 100_000_000
"""It says the pose a second time, for viewers: with each one it would be a tenth of a log."""
PLACE_EVERY_NS = 1_900_000_000
"""With every second status: in which world it is, and what is near. A scene shows obstacles beyond
the eye's reach as well, for as long."""
_PUBLISHED = (RETINA, POSE, TRANSFORM, SCENE, CONTACT, BODY, STATUS, LEASE)


@dataclass(frozen=True, slots=True)
class Journey:
    """Length and contacts of a drive."""

    steps: int
    contacts: int
    distance_m: float


def gate_settings(
    body: Body,
    *,
    auto_arm: bool,
    hold_to_run: bool = False,
    arm_each_runtime: bool = False,
    lockstep: bool = False,
) -> GateSettings:
    """What a simulated body decides for itself: by its world, and by the eye that it was built for.

    Args:
        body: the robot.
        auto_arm: whether it is armed without being asked.
        hold_to_run: whether only a held button arms it.
        arm_each_runtime: whether an arm counts for one runtime.
        lockstep: whether time is counted in steps.
    """
    return GateSettings(
        max_input_age_s=body.contract.max_input_age_s,
        limits=body.limits,
        auto_arm=auto_arm,
        hold_to_run=hold_to_run,
        arm_each_runtime=arm_each_runtime,
        lockstep=lockstep,
        safe=body.safe,
    )


def settings_anew(body: Body, settings: GateSettings) -> GateSettings:
    """The same for a body that was built anew: who may arm it does not depend on its eye."""
    return replace(
        settings,
        max_input_age_s=body.contract.max_input_age_s,
        limits=body.limits,
        safe=body.safe,
    )


class RetinaOutlet(Protocol):
    """Publishes retinas."""

    @property
    def sender(self) -> bytes:
        """The identifier that they carry: commands must repeat it."""
        ...

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
        self,
        bus: "Bus",
        body: Body,
        robot: str,
        retinas: RetinaOutlet | None = None,
        overflows: Callable[[], int] = lambda: 0,
    ) -> None:
        self._publishers = {topic: bus.publisher(topic) for topic in _PUBLISHED}
        self._retinas = self._publishers[RETINA] if retinas is None else retinas
        self._body = body
        self._robot = robot
        self._overflows = overflows
        self._flood = FloodNotice(f"the body of {robot}")
        self._info = encode_body(body.info)
        self._has_news = False
        self._steps = 0
        self._every_second = Throttle()
        self._lease_period = Throttle(SAID_EVERY_NS)
        self._transform_period = Throttle(TRANSFORM_EVERY_NS)
        self._place_period = Throttle(PLACE_EVERY_NS)
        self._said_lease: object = None

    def has_listener(self, topic: Topic) -> bool:
        """Whether anyone listens to a topic."""
        return self._publishers[topic].has_listener

    def show(self, body: Body) -> None:
        """Publish the state of another body from now on, which is said at once."""
        self._body, self._info, self._has_news = body, encode_body(body.info), True

    def publish(
        self, contact: BodyPose | None, account: Account, now_ns: int, *, again: bool = False
    ) -> None:
        """Publish the state of the body: the retina first, because the runtime waits for it.

        Args:
            contact: where a collision began; None without one.
            account: whom the body obeys, and what it refused.
            now_ns: time of the state.
            again: while a slow sensor sends nothing, its last retina is published again.
        """
        is_new, retina = self._body.sends_anew, self._body.see()
        if is_new or again:
            payload = encode_retina(retina, self._body.contract.retina, now_ns)
            self._retinas.put(payload, now_ns)
        place = self._body.place
        self._publishers[POSE].put(encode_pose(place, now_ns), now_ns)
        if self._transform_period.is_due(now_ns):
            self._publishers[TRANSFORM].put(encode_transform(place, self._robot, now_ns), now_ns)
        if contact is not None:
            payload = encode_contact(self._body.contacts, contact.x_m, contact.y_m, now_ns)
            self._publishers[CONTACT].put(payload, now_ns)
        self._steps += 1
        if self._lease_period.is_due(now_ns) or account.news != self._said_lease:
            self._said_lease = account.news
            self._publishers[LEASE].put(encode_lease(account), now_ns)
        if self._every_second.is_due(now_ns) or self._has_news:
            self._publish_every_second(account, now_ns, is_another=self._has_news)
            self._has_news = False

    def _publish_every_second(self, account: Account, now_ns: int, *, is_another: bool) -> None:
        # Again and again: a recorder that joins later shall know where it is, too.
        if self._place_period.is_due(now_ns) or is_another:
            self._publishers[BODY].put(self._info, now_ns)
            near = self._body.simulation.outlines_near(0)
            self._publishers[SCENE].put(encode_scene(near, now_ns), now_ns)
        status = Status(
            node=BODY_NODE,
            ticks=self._steps,
            inbox_overflows=self._overflows(),
            verdicts=account.refused,
            guard=self._body.guard_state,
        )
        self._publishers[STATUS].put(encode_status(status), now_ns)
        self._flood.look(self._overflows())


class Bridge:
    """Connects a body to the bus, with a gate between the two.

    Args:
        bus: an open session; its sender is the body's identifier, which drive commands repeat.
        body: the robot.
        robot: first part of every key.
        inbox: where the bus delivers the commands.
        settings: what the body decides for itself.
        retinas: where the retinas go; straight to the bus by default.
        latch: keeps a stop that outlives the body; without one, a stop ends with it.
        following: builds the body anew where a runtime with another contract holds it; without
            it, the body stays what it is.
    """

    def __init__(
        self,
        bus: "Bus",
        body: Body,
        robot: str,
        inbox: Inbox,
        settings: GateSettings,
        retinas: RetinaOutlet | None = None,
        latch: StopLatch | None = None,
        following: Following | None = None,
    ) -> None:
        self._following = following
        self._bus = bus
        self._body = body
        self._inbox = inbox
        # A flood of commands, or of anything else, must not push a stop out of a full inbox.
        self._controls, self._stops = Inbox(), Inbox()
        self._latch = latch
        self._retinas = retinas
        self._gate = Gate.closed(bus.sender, settings, latch.stopped if latch else "")
        self._publisher = StatePublisher(bus, body, robot, retinas, self._overflows)
        self.has_heard = False
        """Whether any command has come."""
        bus.subscribe([COMMAND], self._take_command)
        bus.subscribe([STOP], self._stops.put)
        others = [topic for topic in HEARD if topic not in (COMMAND, STOP)]
        bus.subscribe(others, self._controls.put)
        bus.announce(BODY_NODE)

    def drive(
        self, pacer: RatePacer, should_stop: Callable[[], bool], steps: int | None = None
    ) -> Journey:
        """Drive in real time, until asked to stop or for a number of steps."""
        done, before_ns = 0, pacer.now_ns()
        self._gate = self._gate.begun(before_ns)
        while steps is None or done < steps:
            wakeup = pacer.wait(should_stop)
            if wakeup is None:
                break
            for message in wakeup.messages:
                self._gate = self._gate.hear(message, message.received_ns)
            if self._following is not None:
                pacer = self._follow(self._following, pacer)
            contact = self._move(wakeup.now_ns, (wakeup.now_ns - before_ns) / 1e9)
            self._publisher.publish(contact, self._gate.lease, wakeup.now_ns)
            before_ns = wakeup.now_ns
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
            # A step takes a command, and a command a retina, as in training.
            self._publisher.publish(contact, self._gate.lease, now_ns, again=True)
            await_command(self._inbox, done, partial(self._hear, now_ns), should_stop)
            contact = self._move(now_ns, period_ns / 1e9)
            done += 1
        return self._journey(done)

    def _take_command(self, message: Message) -> None:
        self.has_heard = True
        self._inbox.put(message)

    def _overflows(self) -> int:
        return self._inbox.overflows + self._controls.overflows

    def _follow(self, following: Following, pacer: RatePacer) -> RatePacer:
        """Stand while a new holder's contract is not known; then go on as it wants to see.

        Returns:
            What paces the body from now on.
        """
        holder = self._gate.holding.holder
        if following.is_open(holder):
            self._gate = self._gate.waiting()
        body = following.successor(holder)
        if body is None:
            return pacer
        rate_hz, former_hz = 1.0 / body.info.step_s, 1.0 / self._body.info.step_s
        body.take_over(self._body)
        self._body = body
        self._publisher.show(body)
        self._gate = self._gate.under(settings_anew(body, self._gate.settings))
        return pacer if rate_hz == former_hz else pacer.at(rate_hz)

    def _hear(self, now_ns: int, message: Message) -> None:
        self._gate = self._gate.hear(message, now_ns)

    def _move(self, now_ns: int, dt_s: float) -> BodyPose | None:
        """Take what operators said, then do what the gate lets through."""
        if self._retinas is not None:
            self._gate = self._gate.renamed(self._retinas.sender)
        # Stops last: of a stop and a reset in one step the stop holds.
        for inbox in (self._controls, self._stops):
            for message in inbox.drain(lambda: now_ns)[0]:
                self._hear(now_ns, message)
        if self._latch is not None:
            self._latch.keep(self._gate.stopped)
        motion, self._gate = self._gate.obey(now_ns, dt_s)
        return self._body.move(motion)

    def _runtime_is_ready(self) -> bool:
        return self._publisher.has_listener(RETINA) and self._bus.is_alive(RUNTIME_NODE)

    def _journey(self, steps: int) -> Journey:
        distance_m = float(self._body.simulation.distance_m[0])
        return Journey(steps, self._body.contacts, distance_m)
