"""Sinks: what the runtime hands its records to. It knows no file format itself."""

from typing import Protocol

from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.wire import Message


class Sink(Protocol):
    """Takes records. It never blocks and never raises."""

    def put(self, message: Message) -> None:
        """Take one message that the loop does not decide on, as it came."""
        ...

    def put_tick(self, record: TickRecord) -> None:
        """Take all that a tick received, decided and sent."""
        ...

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """Take what the controller remembers between two ticks; it is encoded elsewhere."""
        ...

    @property
    def state(self) -> str:
        """`on`, `off`, or why the recording stopped."""
        ...


class NoSink:
    """Records nothing."""

    state = "off"

    def put(self, message: Message) -> None:
        """See `Sink.put`."""

    def put_tick(self, record: TickRecord) -> None:
        """See `Sink.put_tick`."""

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`."""
