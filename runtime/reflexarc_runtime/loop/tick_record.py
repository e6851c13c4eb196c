"""All that one tick leaves to be recorded, handed over in one piece.

The loop only puts it together; what a log holds of it is made where it is written.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from reflexarc_runtime.messages.topics import COMMAND, TICK
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding


@dataclass(frozen=True)
class LoopIdentity:
    """Which loop it was: the same at every tick."""

    robot: str
    sender: bytes


class TickRecord(NamedTuple):  # made at every tick; a frozen dataclass takes four times as long
    """What a tick received, what it decided, and what it sent."""

    received: tuple[Message, ...]
    """Oldest first."""
    tick: bytes
    """`reflexarc.Tick`, as it goes on the bus."""
    command: bytes | None
    """As it was sent; None if it was not, as the watchdog spoke in its place."""
    number: int
    """The tick's index."""
    now_ns: int
    loop: LoopIdentity

    def extent(self) -> tuple[int, int]:
        """How many messages it is, and the bytes of their payloads."""
        received, tick, command = self[:3]
        records, size = len(received) + 1, len(tick)
        if command is not None:
            records, size = records + 1, size + len(command)
        for message in received:
            size += len(message.payload)
        return records, size

    def messages(self) -> Iterator[Message]:
        """What was received, then the tick that used it: replay relies on this order."""
        yield from self.received
        robot, sender = self.loop.robot, self.loop.sender
        attachment = pack_stamp(Stamp(self.number, self.now_ns, sender))
        for topic, payload in ((TICK, self.tick), (COMMAND, self.command)):
            if payload is not None:
                encoding = protobuf_encoding(topic.schema)
                yield Message(topic.key(robot), payload, encoding, attachment, self.now_ns)
