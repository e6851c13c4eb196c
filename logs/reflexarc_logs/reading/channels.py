"""The channels of a log: what all messages of one have in common."""

from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, McapRecord, Schema

from reflexarc_logs.container.remedy import recovery
from reflexarc_logs.container.writing import SENDER
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import NO_SENDER, SENDER_BYTES


class LogStream(NamedTuple):
    """What all messages of a channel have in common."""

    topic: str
    """With a leading slash: "/robot0/retina"."""
    schema: str
    """Full name of the protobuf message."""
    sender: bytes
    """16 bytes; zeros in logs that do not say."""


class Channels:
    """The channels and schemas read so far.

    Args:
        path: of the file.
        publish_shift_ns: how far its publish times lie behind the senders' clocks.
    """

    def __init__(self, path: Path, publish_shift_ns: int = 0) -> None:
        self.publish_shift_ns = publish_shift_ns
        self.streams: dict[int, LogStream] = {}
        """By the channel's number."""
        self._path = path
        self._schemas: dict[int, str] = {}

    def learn(self, record: McapRecord) -> None:
        """Take a record that is no message."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            schema = self._schemas.get(record.schema_id, "")
            self.streams[record.id] = LogStream(record.topic, schema, _sender(record))

    def of(self, channel: int) -> LogStream:
        """The stream of a channel.

        Raises:
            LogError: nothing says what it is.
        """
        stream = self.streams.get(channel)
        if stream is None:
            advice = f"{recovery(self._path)} saves the rest"
            raise LogError(f"{self._path}: a message on an unknown channel; {advice}")
        return stream


def _sender(channel: Channel) -> bytes:
    """The identifier in a channel's metadata; of a damaged one none."""
    text = channel.metadata.get(SENDER, "")
    try:
        return bytes.fromhex(text).ljust(SENDER_BYTES, b"\0")[:SENDER_BYTES]
    except ValueError:
        return NO_SENDER
