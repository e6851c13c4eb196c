"""The gate between a bus and a motor: the last place at which a command can be refused.

    hear(message, now_ns) → gate           one message of an operator or a runtime
    obey(now_ns, dt_s) → (motion, gate)    what the body does now
    lease                                  what it says about that on `<robot>/lease`

It is pure: no clock, bus or file. All times are of the body's own clock; a command repeats the
source time of the input that led to it, which the body itself had set, so no two clocks are ever
compared. The rules, in the order in which they are asked:

1. A stop, from whomever and however garbled, holds until a reset. A reset disarms.
2. Until it is armed the body stands; it is armed by an arm, or while a button is held. See
   `hold.py`.
3. A command counts if its encoding, attachment and speeds are in order, and if it is safe or names
   this body, a time that is past, and is still valid by the command's and by the body's measure.
4. The first sender of a command that counts gets the lease, and is the only one that is obeyed,
   until its release or its silence. See `lease.py`. Where an arm counts for one runtime, another
   one that gets the lease disarms.
5. What is obeyed is slowed to the body's own limits. See `limits.py`.

Whatever is refused is counted by reason. Whether anybody has a liveliness token decides nothing.
"""

from dataclasses import dataclass, field, replace

from reflexarc_runtime.decision import Command
from reflexarc_runtime.messages.controls import stop_reason
from reflexarc_runtime.messages.topics import (
    ARM,
    COMMAND,
    HOLD_TO_RUN,
    RELEASE,
    RESET,
    STOP,
    Topic,
    topic_of,
)
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.account import Account
from reflexarc_sim_bridge.body.gate.hold import Button
from reflexarc_sim_bridge.body.gate.lease import NOBODY, Lease
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion, eased, slowed
from reflexarc_sim_bridge.body.gate.reading import (
    fault_of_operator,
    gives_back_other,
    read_command,
    read_grip,
)
from reflexarc_sim_bridge.body.gate.refusal import Refusal
from reflexarc_sim_bridge.body.gate.settings import GateSettings

HEARD: tuple[Topic, ...] = (COMMAND, STOP, RESET, ARM, RELEASE, HOLD_TO_RUN)
"""The topics that a body with a gate subscribes to."""


@dataclass(frozen=True, slots=True)
class Gate:
    """Decides what a body does. Begin with `Gate.closed`."""

    own: bytes
    """The body's own identifier, 16 bytes: drive commands must repeat it."""
    settings: GateSettings
    allowed: bool
    """Whether it is armed without a button."""
    stopped: str = ""
    """Why the body stands until a reset comes; empty if it need not."""
    holding: Lease = field(default_factory=Lease)
    wanted: Command | None = None
    """The last command of the holder, since the last stop, reset or arm."""
    motion: Motion = STANDSTILL
    """What the body did last."""
    refusals: tuple[tuple[str, int], ...] = ()
    button: Button = field(default_factory=Button)
    armed_for: bytes = NOBODY
    """The runtime for which the last arm counts; `NOBODY`: the next one that gets the lease."""

    @classmethod
    def closed(cls, own: bytes, settings: GateSettings, stopped: str = "") -> "Gate":
        """The gate of a body that has just begun.

        Args:
            own: the identifier that the body's messages carry.
            settings: what it decides for itself.
            stopped: the reason of a stop that it was told before it ended; empty without one.
        """
        return cls(own, settings, settings.auto_arm, stopped)

    def begun(self, now_ns: int) -> "Gate":
        """The gate when the body begins: a button that went down before that does not count."""
        return replace(self, button=self.button.let_go(now_ns))

    def renamed(self, own: bytes) -> "Gate":
        """The gate of a body whose messages carry another identifier from now on."""
        if own == self.own:
            return self
        button = self.button.let_go(self.button.until_ns)
        return replace(self, own=own, wanted=None, button=button)

    @property
    def armed(self) -> bool:
        """Whether it takes commands, unless it is stopped."""
        return self.allowed or self.button.is_held

    def under(self, settings: GateSettings) -> "Gate":
        """The gate of a body that was built anew: it obeys nothing that was said before."""
        return replace(self, settings=settings, wanted=None)

    def waiting(self) -> "Gate":
        """The gate that has forgotten what it was told last, and so stands until the next word."""
        return self if self.wanted is None else replace(self, wanted=None)

    def hear(self, message: Message, now_ns: int) -> "Gate":
        """The gate after a message; never raises.

        Args:
            message: of one of the topics `HEARD`; any other one changes nothing.
            now_ns: when it arrived, on the body's clock.
        """
        topic, gate = topic_of(message.key), self._at(now_ns)
        if topic is COMMAND:
            return gate._hear_command(message, now_ns)
        if topic is STOP:
            reason, button = stop_reason(message), gate.button.let_go(now_ns)
            return replace(gate, stopped=gate.stopped or reason, wanted=None, button=button)
        if topic is HOLD_TO_RUN:
            return gate._hear_button(message, now_ns)
        if topic in (RESET, ARM, RELEASE):
            return gate._hear_operator(topic, message, now_ns)
        return gate

    def obey(self, now_ns: int, dt_s: float) -> tuple[Motion, "Gate"]:
        """What the body does now, within its limits, and the gate after it.

        Args:
            now_ns: on the body's clock.
            dt_s: time since the last call, in which the body can have become faster.
        """
        gate = self._at(now_ns)
        holding = gate.holding.at(now_ns, gate.settings.silence_ns)
        motion = gate._motion(holding, now_ns, dt_s)
        if motion == gate.motion and holding is gate.holding:
            return motion, gate
        return motion, replace(gate, holding=holding, motion=motion)

    @property
    def lease(self) -> Account:
        """Whom the body obeys, whether it is armed or stopped, and what it refused."""
        return Account(
            self.holding,
            self.armed,
            self.stopped,
            self._state(),
            self.refusals,
            self.own,
            self.button.by,
            self.settings.hold_to_run,
        )

    def _at(self, now_ns: int) -> "Gate":
        """The gate now: a button that is no longer held lets go, and what it let in is over."""
        button = self.button.at(now_ns)
        return self if button is self.button else self._with(button)

    def _with(self, button: Button) -> "Gate":
        """The gate with another button: what was wanted before it changed hands is over."""
        was, gate = self.armed, replace(self, button=button)
        return gate if gate.armed == was else replace(gate, wanted=None)

    def _hear_button(self, message: Message, now_ns: int) -> "Gate":
        grip = read_grip(message)
        if isinstance(grip, Refusal):
            return self._refuse(grip)
        if grip.body != self.own:
            return self._refuse(Refusal.OTHER_BODY)
        if self.stopped and grip.held:
            return self._refuse(Refusal.STOPPED)
        button = self.button.heard(grip, now_ns)
        return self._refuse(button) if isinstance(button, Refusal) else self._with(button)

    def _hear_command(self, message: Message, now_ns: int) -> "Gate":
        read = read_command(message)
        if isinstance(read, Refusal):
            return self._refuse(read)
        sender, command = read
        refusal = self._fault_of(command, now_ns)
        if refusal is not None:
            return self._refuse(refusal)
        holding = self.holding.claimed(sender, now_ns, self.settings.silence_ns)
        if holding is None:
            waits = self.holding.former == sender
            return self._refuse(Refusal.RELEASED if waits else Refusal.OTHER_SENDER)
        gate = self._handed_to(holding.holder) if self.settings.arm_each_runtime else self
        return gate._take(command, holding)

    def _handed_to(self, holder: bytes) -> "Gate":
        """The gate of a body whose arm counts for one runtime, when this one holds it."""
        if not self.allowed or self.armed_for == holder:
            return self
        if self.armed_for == NOBODY:
            return replace(self, armed_for=holder)
        return replace(self, allowed=False, armed_for=NOBODY, wanted=None)

    def _fault_of(self, command: Command, now_ns: int) -> Refusal | None:
        """Why a command does not count, whoever sent it. A safe one names neither body nor time."""
        if command.source_time_ns is None:
            return None
        if command.body != self.own:
            return Refusal.OTHER_BODY
        if command.source_time_ns > now_ns:
            return Refusal.FUTURE
        return None if self._is_valid(command, now_ns) else Refusal.OLD

    def _is_valid(self, command: Command, now_ns: int) -> bool:
        if command.source_time_ns is None:
            return True
        valid_for_ns = min(command.valid_for_ns, self.settings.valid_for_ns)
        return 0 <= now_ns - command.source_time_ns < valid_for_ns

    def _take(self, command: Command, holding: Lease) -> "Gate":
        """The gate after a command of the holder, which may still have to stand."""
        if not (self.armed and not self.stopped):
            after = replace(self, holding=holding)
            reason = Refusal.STOPPED if self.stopped else Refusal.DISARMED
            return after if command.is_safe else after._refuse(reason)
        after = Gate(  # every field in order: `replace` takes three times as long
            self.own,
            self.settings,
            self.allowed,
            self.stopped,
            holding,
            command,
            self.motion,
            self.refusals,
            self.button,
            self.armed_for,
        )
        if command.is_safe or not slowed(command, self.settings.limits)[1]:
            return after
        return after._refuse(Refusal.TOO_FAST)

    def _hear_operator(self, topic: Topic, message: Message, now_ns: int) -> "Gate":
        refusal = fault_of_operator(topic, message)
        if refusal is not None:
            return self._refuse(refusal)
        if topic is RESET:
            return self._reset(now_ns)
        if topic is RELEASE and gives_back_other(message, self.holding.holder):
            return self
        if topic is RELEASE:
            holding = self.holding.released(now_ns, self.settings.silence_ns)
            return replace(self, holding=holding, wanted=None)
        if self.stopped:
            return self._refuse(Refusal.STOPPED)
        if self.settings.hold_to_run:
            return self._refuse(Refusal.NEEDS_BUTTON)
        holder = self.holding.at(now_ns, self.settings.silence_ns).holder
        wanted = self.wanted if self.armed else None
        return replace(self, allowed=True, armed_for=holder, wanted=wanted)

    def _reset(self, now_ns: int) -> "Gate":
        return replace(
            self,
            allowed=self.settings.auto_arm,
            stopped="",
            wanted=None,
            motion=STANDSTILL,
            button=self.button.let_go(now_ns),
        )

    def _motion(self, holding: Lease, now_ns: int, dt_s: float) -> Motion:
        if self.stopped or not self.armed:
            return STANDSTILL
        command, settings = self.wanted, self.settings
        if command is None or command.is_safe or holding.is_free:
            return settings.safe
        if not self._is_valid(command, now_ns):
            return settings.safe
        motion, _ = slowed(command, settings.limits)
        return eased(self.motion, motion, settings.limits.acceleration_mps2, dt_s)

    def _refuse(self, reason: Refusal) -> "Gate":
        counts = dict(self.refusals)
        counts[reason.value] = counts.get(reason.value, 0) + 1
        return replace(self, refusals=tuple(counts.items()))

    def _state(self) -> str:
        if self.stopped:
            return "stopped: waiting for a reset"
        if not self.armed:
            return (
                "waiting for a held button" if self.settings.hold_to_run else "waiting for an arm"
            )
        if self.holding.is_free:
            return "waiting for a command"
        return "standing" if self.motion.stands else "driving"
