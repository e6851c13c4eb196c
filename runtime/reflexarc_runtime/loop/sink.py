"""Sinks: what the runtime hands its records to. It knows no file format itself."""

from typing import Protocol

from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.messages.wire import Message


class Sink(Protocol):
    """Takes records. It never blocks and never raises."""

    def put(self, message: Message) -> None:
        """Take one message, as it came or as it was sent."""
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

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`."""
