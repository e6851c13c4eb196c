"""Where the runtime hands its records. The runtime knows no file format."""

from typing import Protocol

from reflexarc_runtime.messages.wire import Message


class Sink(Protocol):
    """Takes records; never blocks, never raises."""

    def put(self, message: Message) -> None:
        """Take one message, as it came or as it was sent."""
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
