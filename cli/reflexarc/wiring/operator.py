"""What an operator says to a body, and how the body's lease shows that it has heard it."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from google.protobuf.message import DecodeError

from reflexarc.wiring.waiting import LISTEN_S, PATIENCE_S, Waiting, Wish, look_around, reason
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.topics import COMMAND, LEASE, Topic
from reflexarc_runtime.messages.wire import Message

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

AGAIN_S = 0.1
"""Time between two repetitions of what has not been acknowledged yet."""

RUNTIME_HEARD_S = 0.7
"""How long a runtime may take to be heard: at its rate, and found on the bus."""

Check = Callable[[pb.Lease], bool]


@dataclass(frozen=True, slots=True)
class OperatorAnswer:
    """What a body said."""

    done: bool
    """Whether it did what it was told."""
    lease: pb.Lease | None
    """The last thing that it said; None: it was not heard at all."""


class Operator:
    """Talks to the body of one robot.

    Args:
        bus: an open session.
        patience_s: how long it waits for an answer.
    """

    def __init__(self, bus: "Bus", patience_s: float) -> None:
        self._bus = bus
        self._patience_s = patience_s
        self._inbox = Inbox()
        self._has_heard = False
        self._verdict: int = pb.VERDICT_UNSPECIFIED
        bus.subscribe([LEASE], self._inbox.put)
        bus.subscribe([COMMAND], self._hear_runtime)

    def insist(
        self, topic: Topic, payload: bytes, is_done: Check, *, stopped: bool | None = None
    ) -> OperatorAnswer:
        """Say something again and again, until body and runtime show that they heard it.

        A runtime shows it by the verdict of its commands; where none is heard for a while, there
        is none.

        Args:
            topic: stop, reset or arm.
            payload: what to say.
            is_done: whether a lease shows it.
            stopped: whether the runtime shall be stopped then; None: it is not asked.
        """
        publisher = self._bus.publisher(topic)
        silent_s = time.monotonic() + (0.0 if stopped is None else RUNTIME_HEARD_S)

        def say() -> None:
            publisher.put(payload, time.monotonic_ns())

        def agreed(lease: pb.Lease) -> bool:
            if self._verdict == pb.VERDICT_UNSPECIFIED:
                return is_done(lease) and time.monotonic() >= silent_s
            fits = stopped is None or (self._verdict == pb.STOPPED) == stopped
            return is_done(lease) and fits

        return self._listen(agreed, say)

    def _hear_runtime(self, message: Message) -> None:
        command = decode_command(message.payload)
        if command is not None:
            self._verdict = int(command.verdict)

    def say_once(self, topic: Topic, payload: bytes, is_done: Check) -> OperatorAnswer:
        """Say something one time to a body that listens, and wait until a lease shows it."""
        publisher, said = self._bus.publisher(topic), False

        def say() -> None:
            nonlocal said
            if publisher.has_listener and not said:
                publisher.put(payload, time.monotonic_ns())
                said = True

        return self._listen(is_done, say)

    def explaining(self, who: str) -> AbstractContextManager[object]:
        """Explains a long silence of the body inside this context."""
        if self._patience_s <= PATIENCE_S + LISTEN_S:
            return nullcontext()  # the complaint at the end says it
        return Waiting(self._bus, self._wish(who), lambda: self._has_heard)

    def explain_silence(self, who: str) -> str:
        """What is heard in place of the body, to be put behind a complaint."""
        wish = self._wish(who)
        return f"; {reason(wish, look_around(self._bus, wish, lambda: time.sleep(LISTEN_S)))}"

    def _wish(self, who: str) -> Wish:
        return Wish(who, "a body", LEASE.key(self._bus.robot))

    def hear(self) -> pb.Lease | None:
        """Wait for what the body says of itself."""
        return self._listen(lambda lease: True, lambda: None).lease

    def _listen(self, is_done: Check, say: Callable[[], None]) -> OperatorAnswer:
        heard: pb.Lease | None = None
        end_s = time.monotonic() + self._patience_s
        again_s = 0.0
        while (now_s := time.monotonic()) < end_s:
            if now_s >= again_s:
                say()
                again_s = now_s + AGAIN_S
            heard = self._take() or heard
            self._has_heard = heard is not None
            if heard is not None and is_done(heard):
                return OperatorAnswer(True, heard)
        return OperatorAnswer(False, heard)

    def _take(self) -> pb.Lease | None:
        message = self._inbox.take(AGAIN_S)
        if message is None:
            return None
        try:
            return pb.Lease.FromString(message.payload)
        except DecodeError:
            return None
