"""`reflexarc arm`, `stop`, `reset` and `release`: what an operator says to a body."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from reflexarc.terminal.keyboard import Keys
from reflexarc.terminal.output import aside, console, plain, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.wiring.operator import Operator, OperatorAnswer
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.messages_pb2 import Lease

MAX_PATIENCE_S = 3600.0


@dataclass(frozen=True)
class Speaking:
    """How an operator's command reaches a body, and how long it waits for its answer."""

    joining: Joining = field(default_factory=Joining)
    patience: float = 3.0
    """Seconds to wait for the body's answer."""
    json: bool = False
    """Print what the body said as one JSON object."""

    def bus(self) -> "Bus":
        """A session on the bus, as an operator; a context manager."""
        from reflexarc_runtime.messages.topics import OPERATOR

        if not 0.0 < self.patience <= MAX_PATIENCE_S:
            raise UsageError(f"--patience: expected above 0 to 3600 s, got {self.patience}")
        end_s = time.monotonic() + self.patience
        return self.joining.bus_in_time(
            OPERATOR, lambda: time.monotonic() > end_s, "reflexarc", quietly=True
        )

    def tell(self, command: str, answer: "OperatorAnswer", silence: str = "") -> int:
        """Print what the body said, or why it is silent; the exit status."""
        if self.json:
            print_json({"done": answer.done, **_plain(answer.lease)})
        elif answer.done and answer.lease is not None:
            console.print(f"{self.joining.robot}: {_words(answer.lease)}", soft_wrap=True)
        if not answer.done:
            aside.print(f"reflexarc {command}: {self._complaint(answer)}{silence}", soft_wrap=True)
        return 0 if answer.done else 1

    def _complaint(self, answer: "OperatorAnswer") -> str:
        robot = self.joining.robot
        if answer.lease is None:
            return f"no body of {robot} answered within {self.patience:g} s"
        return f"{robot} has not done it within {self.patience:g} s: {_words(answer.lease)}"


@dataclass(frozen=True)
class ArmCommand:
    """Let a body take commands: after its start and after a reset it stands until then.

    With --hold it may drive only for as long as this command lives: until a key is pressed, Ctrl-C,
    or any end of this process, whatever its cause. Ends with 1 if no body says that it is armed, or
    if the body no longer felt the button.

    Examples:
      reflexarc arm
      reflexarc arm --hold
      reflexarc arm --robot rover1
    """

    hold: bool = False
    """Hold a button instead: let go, the body is disarmed, unless it was armed otherwise."""
    speaking: Speaking = field(default_factory=Speaking)

    def run(self) -> int:
        """Repeat it until the body says that it is armed; or hold the button until asked not to."""
        from reflexarc_runtime import messages_pb2 as pb
        from reflexarc_runtime.messages.topics import ARM

        if self.hold:
            return _hold(self.speaking)
        payload = pb.Arm(reason="reflexarc arm").SerializeToString()
        return _insist(self.speaking, "arm", lambda operator: operator.insist(ARM, payload, _runs))


@dataclass(frozen=True)
class StopCommand:
    """Make a body and its runtime stand until `reflexarc reset`, even if they are started again.

    It is no emergency stop: it goes over a network, by programs. It is repeated until the body says
    that it is stopped, and ends with 1 if none does.

    Examples:
      reflexarc stop
      reflexarc stop --reason "someone in the hall"
    """

    reason: str = "reflexarc stop"
    """Why; the body, the runtime and the log repeat it."""
    speaking: Speaking = field(default_factory=Speaking)

    def run(self) -> int:
        """Repeat it until the body says that it is stopped."""
        from reflexarc_runtime.messages.controls import encode_stop
        from reflexarc_runtime.messages.topics import STOP

        payload = encode_stop(self.reason)
        return _insist(
            self.speaking,
            "stop",
            lambda operator: operator.insist(
                STOP, payload, lambda lease: bool(lease.stopped), stopped=True
            ),
        )


@dataclass(frozen=True)
class ResetCommand:
    """End a stop. The body is disarmed then, unless it arms itself.

    Ends with 1 if the body does not say that it is no longer stopped.

    Examples:
      reflexarc reset
      reflexarc reset --robot rover1
    """

    speaking: Speaking = field(default_factory=Speaking)

    def run(self) -> int:
        """Repeat it until the body says that no stop holds."""
        from reflexarc_runtime import messages_pb2 as pb
        from reflexarc_runtime.messages.topics import RESET

        payload = pb.Reset(reason="reflexarc reset").SerializeToString()
        return _insist(
            self.speaking,
            "reset",
            lambda operator: operator.insist(
                RESET, payload, lambda lease: not lease.stopped, stopped=False
            ),
        )


@dataclass(frozen=True)
class ReleaseCommand:
    """Take the lease from the runtime that drives, so that another one of the robot can drive.

    The former holder gets it again only if nobody else wants it. Ends with 1 if the body does not
    say that the lease has changed hands.

    Examples:
      reflexarc release
      reflexarc release --robot rover1
    """

    speaking: Speaking = field(default_factory=Speaking)

    def run(self) -> int:
        """Say it once, to the holder that there is, and wait for the change."""
        return _insist(self.speaking, "release", _release)


def _release(operator: "Operator") -> "OperatorAnswer":
    """A repetition would take the lease from the next one as well, so it is said once."""
    from reflexarc.wiring.operator import OperatorAnswer
    from reflexarc_runtime import messages_pb2 as pb
    from reflexarc_runtime.messages.topics import RELEASE

    before = operator.hear()
    if before is None or not before.holder:
        return OperatorAnswer(before is not None, before)
    payload = pb.Release(reason="reflexarc release").SerializeToString()
    return operator.say_once(RELEASE, payload, lambda now: now.holder != before.holder)


def _runs(lease: "Lease") -> bool:
    return lease.armed and not lease.stopped


def _insist(speaking: Speaking, command: str, say: "Callable[[Operator], OperatorAnswer]") -> int:
    from reflexarc.wiring.operator import Operator

    who = f"reflexarc {command}"
    with speaking.bus() as bus:
        operator = Operator(bus, speaking.patience)
        with operator.explaining(who):
            answer = say(operator)
        silence = "" if answer.lease else operator.explain_silence(who)
    return speaking.tell(command, answer, silence)


def _hold(speaking: Speaking) -> int:
    """Hold the button until a key or a signal; the exit status."""
    from reflexarc.wiring.holding import Holder

    with StopFlag() as stop, Keys() as keys, speaking.bus() as bus:
        holder = Holder(bus, speaking.patience)
        answer = holder.press(stop)
        if answer.done:
            robot = speaking.joining.robot
            aside.print(f"reflexarc arm: {robot} may drive until a key, Ctrl-C or my end")
            was_felt = holder.hold(lambda: stop() or keys.was_pressed())
            answer = holder.let_go()
            if not was_felt:
                aside.print(f"reflexarc arm: {robot} no longer felt the button; press it anew")
                answer = replace(answer, done=False)
    return speaking.tell("arm", answer)


def _words(lease: "Lease") -> str:
    """What a body says of itself, on one line."""
    if lease.stopped:
        return f"stopped ({plain(lease.stopped)})"
    holder = f"obeys {lease.holder.hex()[:8]}" if lease.holder else "obeys nobody yet"
    return f"{'armed' if lease.armed else 'not armed'}, {holder}, {plain(lease.state)}"


def _plain(lease: "Lease | None") -> dict[str, object]:
    if lease is None:
        return {"heard": False}
    return {
        "heard": True,
        "holder": lease.holder.hex(),
        "epoch": lease.epoch,
        "armed": lease.armed,
        "stopped": lease.stopped,
        "state": lease.state,
        "held_by": lease.held_by.hex(),
        "hold_to_run": lease.hold_to_run,
        "refused": dict(lease.refused),
    }
