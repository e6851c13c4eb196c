"""Holds the button that lets a body drive, for as long as this process lives and repeats it.

It repeats what it heard from the body last (see `body/gate/hold.py`), from the thread that looks at
keys and signals: if that hangs or is stopped, so does the body. What was let go, or was lost on the
way, is not taken up again: another press is another `Holder`.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from google.protobuf.message import DecodeError

from reflexarc.wiring.operator import OperatorAnswer
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.topics import HOLD_TO_RUN, LEASE
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

AGAIN_S = 0.05
"""Time between two repetitions: ten of them in what a body waits for one."""
SILENT_S = 1.0
"""A body that is not heard for so long has let go, or is gone."""


@dataclass(frozen=True, slots=True)
class _Heard:
    """What a body said of itself, and when by its own clock."""

    lease: pb.Lease
    body_ns: int
    received_s: float


class Holder:
    """A button for the body of one robot: the first one that is heard.

    Args:
        bus: an open session.
        patience_s: how long it waits for an answer.
    """

    def __init__(self, bus: "Bus", patience_s: float) -> None:
        self._me = bus.sender
        self._patience_s = patience_s
        self._inbox = Inbox()
        self._publisher = bus.publisher(HOLD_TO_RUN)
        self._heard: _Heard | None = None
        self._pressed_ns: int | None = None
        bus.subscribe([LEASE], self._inbox.put)

    def press(self, must_let_go: Callable[[], bool]) -> OperatorAnswer:
        """Press it, and wait until the body says that it feels it."""
        end_s = time.monotonic() + self._patience_s
        while not (self._is_felt() or must_let_go() or time.monotonic() >= end_s):
            self._say(held=True)
            self._rest()
        return OperatorAnswer(self._is_felt(), self._lease())

    def hold(self, must_let_go: Callable[[], bool]) -> bool:
        """Keep it down until asked to let go; False: the body did not feel it any more."""
        while not must_let_go():
            if not self._is_felt():
                return False
            self._say(held=True)
            self._rest()
        return True

    def let_go(self) -> OperatorAnswer:
        """Let it go, and wait until the body says that it noticed."""
        end_s = time.monotonic() + self._patience_s
        self._say(held=False)
        self._rest()
        while self._is_held_by_me() and time.monotonic() < end_s:
            self._say(held=False)
            self._rest()
        return OperatorAnswer(not self._is_held_by_me(), self._lease())

    def _say(self, *, held: bool) -> None:
        heard = self._heard
        if heard is None:
            return
        if self._pressed_ns is None:
            self._pressed_ns = heard.body_ns
        message = pb.HoldToRun(
            held=held,
            body=heard.lease.body,
            source_time_ns=heard.body_ns,
            pressed_time_ns=self._pressed_ns,
        )
        self._publisher.put(message.SerializeToString(), time.monotonic_ns())

    def _rest(self) -> None:
        time.sleep(AGAIN_S)
        for message in self._inbox.drain(time.monotonic_ns)[0]:
            heard = _read(message)
            is_mine = self._heard is None or (heard and heard.lease.body == self._heard.lease.body)
            self._heard = heard if heard is not None and is_mine else self._heard

    def _is_felt(self) -> bool:
        heard = self._heard
        is_recent = heard is not None and time.monotonic() - heard.received_s < SILENT_S
        return is_recent and self._is_held_by_me()

    def _is_held_by_me(self) -> bool:
        return self._heard is not None and self._heard.lease.held_by == self._me

    def _lease(self) -> pb.Lease | None:
        return self._heard.lease if self._heard is not None else None


def _read(message: Message) -> _Heard | None:
    try:
        lease = pb.Lease.FromString(message.payload)
        body_ns = unpack_stamp(message.attachment).time_ns
    except (DecodeError, UndecodableError):
        return None
    return _Heard(lease, body_ns, message.received_ns / 1e9)
