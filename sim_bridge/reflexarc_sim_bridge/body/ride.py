"""A body and the controller that drives it, step by step, without a bus and without a clock.

    ride.look(now_ns) → what the controller decides on what the body sees
    ride.obey(command, now_ns) → the body moves for a step

It is what a body and a loop do in lockstep: a step takes a command, and a command a look. A ride
can also be led along a drive that was recorded (`lead`): the body is then where it was, and the
controller sees and remembers what it would have, had it come along.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.controller_state import Inputs, Serving, State
from reflexarc_runtime.decision import Command, Decision
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, RETINA
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.serving.swapping import AnyController, handed_over
from reflexarc_sim_bridge.body.body import Body, BodyPose
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion, eased, slowed
from reflexarc_sim_bridge.simulation.putting import put_at
from reflexarc_sim_bridge.simulation.surroundings import AgentSurroundings

SAME_M = 1e-9
"""Places that are no farther apart, in metres and radians, are one: a log's are rounded."""

_SENDER = b"a ride's body\0\0\0"


@dataclass(frozen=True)
class HandOver:
    """From a look on another policy decides, or the same one anew."""

    from_ns: int
    """Time of that look, on the body's clock."""
    policy_hash: str
    former: str = ""
    """Who decides if it fails; empty: nobody."""


@dataclass(frozen=True)
class Kept:
    """A ride at one moment, to be gone back to."""

    agents: dict[str, npt.NDArray[np.generic]]
    contacts: int
    state: State
    motion: Motion
    command: Command | None
    looks: int
    handed_over: int
    """How often another policy had taken over."""


class Ride:
    """A body under a controller.

    Args:
        body: with near lists all round.
        controller: decides on retinas.
        every: steps of the body for one decision.
        resends: whether a retina comes at every step, however slow the sensor, as in lockstep.
        hand_overs: who decides from when on, in order; the controller knows all of them.
    """

    def __init__(
        self,
        body: Body,
        controller: AnyController,
        *,
        every: int = 1,
        resends: bool = True,
        hand_overs: Sequence[HandOver] = (),
    ) -> None:
        self.body, self._controller = body, controller
        self._every, self._resends = every, resends
        self._hand_overs, self._handed_over = hand_overs, 0
        self._state, self._motion, self._looks = State(), STANDSTILL, 0
        self._command: Command | None = None
        self._around = AgentSurroundings(body.simulation)

    def look(self, now_ns: int) -> Decision | None:
        """See, and decide; None at a step between two decisions."""
        body, comes = self.body, self._resends or self.body.sends_anew
        payload = encode_retina(body.see(), body.contract.retina, now_ns)
        number, self._looks = self._looks, self._looks + 1
        if number % self._every:
            return None
        self._hand_over(now_ns)
        stamp = pack_stamp(Stamp(number, now_ns, _SENDER))
        encoding = protobuf_encoding(RETINA.schema)
        message = Message(RETINA.key(DEFAULT_ROBOT), payload, encoding, stamp, now_ns)
        inputs = Inputs((message,) if comes else (), number // self._every)
        self._state, decision = self._controller.step(self._state, inputs, now_ns)
        self._command = decision.command
        return decision

    def _hand_over(self, now_ns: int) -> None:
        """Let whoever decides from this look on decide."""
        for next_one in self._hand_overs[self._handed_over :]:
            if next_one.from_ns > now_ns:
                return
            serving = Serving(next_one.policy_hash, next_one.former)
            self._state = handed_over(self._state, serving)
            self._handed_over += 1

    def obey(self, now_ns: int) -> BodyPose | None:
        """Move for a step as the controller said last.

        Returns:
            Where a collision began; None without one.
        """
        return self.body.move(self.told(self._command, now_ns))

    def told(self, command: Command | None, now_ns: int) -> Motion:
        """What the body does now if it is told this, within its limits."""
        limits = self.body.limits
        if (
            command is None
            or command.is_safe
            or not _is_valid(command, now_ns, limits.valid_for_ns)
        ):
            self._motion = self.body.safe
        else:
            wanted, dt_s = slowed(command, limits)[0], self.body.info.step_s
            self._motion = eased(self._motion, wanted, limits.acceleration_mps2, dt_s)
        return self._motion

    def lead(self, motion: Motion) -> None:
        """Move for a step as was recorded, whatever the controller says."""
        self._motion = motion
        self.body.move(motion)

    def put(self, place: BodyPose, steps: int) -> float:
        """Be at a place at a time; how far it was from there, in metres or radians."""
        here, simulation = self.body.place, self.body.simulation
        apart = max(
            abs(here.x_m - place.x_m),
            abs(here.y_m - place.y_m),
            abs(math.remainder(here.heading_rad - place.heading_rad, 2.0 * math.pi)),
        )
        if apart > SAME_M or int(simulation.params.agents.state["steps"][0]) != steps:
            put_at(simulation, place.x_m, place.y_m, place.heading_rad, steps)
        return apart

    @property
    def clearance_m(self) -> float:
        """From the body's outline to the nearest obstacle around it, up to its eye's range."""
        clearance_m, ahead_s = np.zeros(1, np.float32), np.zeros(1, np.float32)
        self._around.measure(clearance_m, ahead_s)
        return float(clearance_m[0])

    def keep(self) -> Kept:
        """This moment."""
        return Kept(
            self.body.simulation.state(),
            self.body.contacts,
            self._state,
            self._motion,
            self._command,
            self._looks,
            self._handed_over,
        )

    def go_back(self, kept: Kept) -> None:
        """Be at a moment again, to the bit."""
        self.body.simulation.restore(kept.agents)
        self.body.contacts = kept.contacts
        self._state, self._motion = kept.state, kept.motion
        self._command, self._looks = kept.command, kept.looks
        self._handed_over = kept.handed_over


def _is_valid(command: Command, now_ns: int, most_ns: int) -> bool:
    """A safe command names no time: it is what the body does without one."""
    since_ns = command.source_time_ns
    return since_ns is not None and 0 <= now_ns - since_ns < min(command.valid_for_ns, most_ns)
