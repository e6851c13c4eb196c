"""The gate between a bus and a motor: the last place at which a command can be refused.

    hear(message, now_ns) → gate           one message of command, stop, reset, arm or release
    obey(now_ns, dt_s) → (motion, gate)    what the body does now
    lease                                  what it says about that on `<robot>/lease`

It is pure: no clock, bus or file. All times are of the body's own clock; a command repeats the
source time of the input that led to it, which the body itself had set, so no two clocks are ever
compared. The rules, in the order in which they are asked:

1. A stop, from whomever and however garbled, holds until a reset. A reset disarms.
2. Until it is armed the body stands.
3. A command counts if its encoding, attachment and speeds are in order, and if it is safe or names
   this body, a time that is past, and is still valid by the command's and by the body's measure.
4. The first sender of a command that counts gets the lease, and is the only one that is obeyed,
   until its release or its silence. See `lease.py`.
5. What is obeyed is slowed to the body's own limits. See `limits.py`.

Whatever is refused is counted by reason. Whether anybody has a liveliness token decides nothing.
"""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.decision import Command
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.controls import stop_reason
from reflexarc_runtime.messages.topics import ARM, COMMAND, RELEASE, RESET, STOP, Topic, topic_of
from reflexarc_runtime.messages.wire import (
    NO_SENDER,
    Message,
    UndecodableError,
    check_encoding,
    unpack_stamp,
)
from reflexarc_sim_bridge.body.gate.lease import Lease
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion, eased, slowed

HEARD: tuple[Topic, ...] = (COMMAND, STOP, RESET, ARM, RELEASE)
"""The topics that a body with a gate subscribes to."""


class Refusal(StrEnum):
    """Why a message was not obeyed as it came, in the words of `<robot>/lease`."""

    ENCODING = "another encoding, or too long"
    UNSIGNED = "no attachment that names a sender"
    UNREADABLE = "unreadable, or speeds that are not finite"
    OTHER_BODY = "meant for another body"
    FUTURE = "of a time to come"
    OLD = "no longer valid"
    OTHER_SENDER = "another one holds the lease"
    RELEASED = "it has just given the lease back"
    STOPPED = "the body is stopped"
    DISARMED = "the body is not armed"
    TOO_FAST = "too fast: slowed down"


@dataclass(frozen=True)
class GateSettings:
    """What a body decides for itself."""

    max_input_age_s: float
    """Silence after which the holder loses the lease, seconds."""
    limits: BodyLimits = field(default_factory=BodyLimits)
    """What the body does at most."""
    auto_arm: bool = False
    """Whether it is armed at its start and after a reset, without being asked."""
    lockstep: bool = False
    """Whether time is counted in steps: then no lease expires."""
    safe: Motion = STANDSTILL
    """What it does when it is armed and there is nothing to obey."""

    def __post_init__(self) -> None:
        if not 0.0 < self.max_input_age_s < 1e9:
            raise UsageError(
                f"max_input_age_s: expected above 0 and finite, got {self.max_input_age_s}"
            )

    @cached_property
    def silence_ns(self) -> int | None:
        """The longest silence of a holder; None: nothing expires."""
        return None if self.lockstep else round(self.max_input_age_s * 1e9)

    @cached_property
    def valid_for_ns(self) -> int:
        """The body's own longest validity of a command."""
        return self.limits.valid_for_ns


@dataclass(frozen=True, slots=True)
class Account:
    """Whom a body obeys and what it refused: what it says on `<robot>/lease`."""

    lease: Lease
    armed: bool
    stopped: str
    state: str
    refused: tuple[tuple[str, int], ...] = ()
    """How many messages were refused or slowed, by reason."""

    @property
    def news(self) -> tuple[bytes, int, bool, str]:
        """What is said at once when it changes; the rest once a second."""
        return self.lease.holder, self.lease.epoch, self.armed, self.stopped


@dataclass(frozen=True, slots=True)
class Gate:
    """Decides what a body does. Begin with `Gate.closed`."""

    own: bytes
    """The body's own identifier, 16 bytes: drive commands must repeat it."""
    settings: GateSettings
    armed: bool
    stopped: str = ""
    """Why the body stands until a reset comes; empty if it need not."""
    holding: Lease = field(default_factory=Lease)
    wanted: Command | None = None
    """The last command of the holder, since the last stop, reset or arm."""
    motion: Motion = STANDSTILL
    """What the body did last."""
    refusals: tuple[tuple[str, int], ...] = ()

    @classmethod
    def closed(cls, own: bytes, settings: GateSettings, stopped: str = "") -> "Gate":
        """The gate of a body that has just begun.

        Args:
            own: the identifier that the body's messages carry.
            settings: what it decides for itself.
            stopped: the reason of a stop that it was told before it ended; empty without one.
        """
        return cls(own, settings, settings.auto_arm, stopped)

    def renamed(self, own: bytes) -> "Gate":
        """The gate of a body whose messages carry another identifier from now on."""
        return self if own == self.own else replace(self, own=own, wanted=None)

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
        topic = topic_of(message.key)
        if topic is COMMAND:
            return self._hear_command(message, now_ns)
        if topic is STOP:
            return replace(self, stopped=self.stopped or stop_reason(message), wanted=None)
        if topic in (RESET, ARM, RELEASE):
            return self._hear_operator(topic, message, now_ns)
        return self

    def obey(self, now_ns: int, dt_s: float) -> tuple[Motion, "Gate"]:
        """What the body does now, within its limits, and the gate after it.

        Args:
            now_ns: on the body's clock.
            dt_s: time since the last call, in which the body can have become faster.
        """
        holding = self.holding.at(now_ns, self.settings.silence_ns)
        motion = self._motion(holding, now_ns, dt_s)
        if motion == self.motion and holding is self.holding:
            return motion, self
        return motion, replace(self, holding=holding, motion=motion)

    @property
    def lease(self) -> Account:
        """Whom the body obeys, whether it is armed or stopped, and what it refused."""
        return Account(self.holding, self.armed, self.stopped, self._state(), self.refusals)

    def _hear_command(self, message: Message, now_ns: int) -> "Gate":
        read = _read_command(message)
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
        return self._take(command, holding)

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
            self.armed,
            self.stopped,
            holding,
            command,
            self.motion,
            self.refusals,
        )
        if command.is_safe or not slowed(command, self.settings.limits)[1]:
            return after
        return after._refuse(Refusal.TOO_FAST)

    def _hear_operator(self, topic: Topic, message: Message, now_ns: int) -> "Gate":
        refusal = _fault_of_operator(topic, message)
        if refusal is not None:
            return self._refuse(refusal)
        if topic is RESET:
            armed = self.settings.auto_arm
            return replace(self, armed=armed, stopped="", wanted=None, motion=STANDSTILL)
        if topic is RELEASE:
            holding = self.holding.released(now_ns, self.settings.silence_ns)
            return replace(self, holding=holding, wanted=None)
        if self.stopped:
            return self._refuse(Refusal.STOPPED)
        return self if self.armed else replace(self, armed=True, wanted=None)

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
            return "waiting for an arm"
        if self.holding.is_free:
            return "waiting for a command"
        return "standing" if self.motion.stands else "driving"


def _read_command(message: Message) -> tuple[bytes, Command] | Refusal:
    """The sender and the command; or why it cannot be believed."""
    try:
        check_encoding(message, COMMAND.schema)
    except UndecodableError:
        return Refusal.ENCODING
    sender = _sender_of(message)
    if sender is None:
        return Refusal.UNSIGNED
    command = decode_command(message.payload)
    return Refusal.UNREADABLE if command is None else (sender, command)


def _sender_of(message: Message) -> bytes | None:
    try:
        sender = unpack_stamp(message.attachment).sender
    except UndecodableError:
        return None
    return None if sender == NO_SENDER else sender


def _fault_of_operator(topic: Topic, message: Message) -> Refusal | None:
    """Why an arm, a reset or a release does not count: unlike a stop, it must be in order."""
    try:
        check_encoding(message, topic.schema)
        topic.message.FromString(message.payload)
    except UndecodableError:
        return Refusal.ENCODING
    except DecodeError:
        return Refusal.UNREADABLE
    return Refusal.UNSIGNED if _sender_of(message) is None else None


def encode_lease(account: Account) -> bytes:
    """`reflexarc.Lease`."""
    lease = account.lease
    message = pb.Lease(
        holder=lease.holder,
        epoch=lease.epoch,
        armed=account.armed,
        stopped=account.stopped,
        state=account.state,
        refused=dict(account.refused),
    )
    return message.SerializeToString()
