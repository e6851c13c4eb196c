"""Writes a log anew with other messages on one of its topics; all else stays as it is.

The new file takes the old one's name when it is whole and on the disk, and not before.
"""

import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from mcap.records import Channel, Header, McapRecord, Message, Metadata, Schema
from mcap.writer import Writer

from reflexarc_logs.container.first_look import Survey, look
from reflexarc_logs.container.record_stream import whole_records
from reflexarc_logs.diffing.message_file import StreamMessage


def record_anew(path: Path, topic: str, said: Sequence[StreamMessage]) -> None:
    """Put messages in the place of those on a topic.

    Args:
        path: a whole log of another system; where it is a link, what it leads to is written anew.
        topic: "/cmd_vel".
        said: its messages from now on, by log time; each stands behind the messages of its time.

    Raises:
        OSError: the disk did not take it.
    """
    real = path.resolve()
    new = real.with_name(f".{real.name}.new")
    try:
        with new.open("wb") as file:
            writer = Writer(file, enable_data_crcs=True)
            _Copy(writer, look(real), topic, said).write()
            file.flush()
            os.fsync(file.fileno())
        shutil.copymode(real, new)
        os.replace(new, real)
    finally:
        new.unlink(missing_ok=True)


class _Copy:
    """The copy of a log, while it is written."""

    def __init__(
        self, writer: Writer, found: Survey, topic: str, said: Sequence[StreamMessage]
    ) -> None:
        self._writer, self._found, self._topic = writer, found, topic
        self._said: Iterator[StreamMessage] = iter(said)
        self._next = next(self._said, None)
        self._number = 0
        self._schemas = {0: 0}
        self._channels: dict[int, int] = {}
        self._recorded = _recorded(found, topic)
        self._dropped: set[int] = set()
        """The channels of the topic."""
        self._own: int | None = None
        """Its channel from now on."""

    def write(self) -> None:
        found = self._found
        for record in whole_records(found.path, found.intact_size, found.size):
            self._copy(record)
        self._say_until(None)
        for name, data in found.attachments.items():
            place = found.places[name]
            self._writer.add_attachment(
                place.created_ns, place.log_ns, place.name, place.media_type, data
            )
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap has no type for it

    def _copy(self, record: McapRecord) -> None:
        match record:
            case Header():
                self._writer.start(record.profile, record.library)
            case Metadata():
                self._writer.add_metadata(record.name, record.metadata)
            case Schema() if record.id not in self._schemas:
                number = self._writer.register_schema(record.name, record.encoding, record.data)
                self._schemas[record.id] = number
            case Channel() if record.id not in self._channels:
                self._copy_channel(record)
            case Message():
                self._copy_message(record)

    def _copy_channel(self, channel: Channel) -> None:
        if channel.topic == self._topic:
            self._dropped.add(channel.id)
            return
        self._channels[channel.id] = self._writer.register_channel(
            channel.topic,
            channel.message_encoding,
            self._schemas[channel.schema_id],
            dict(channel.metadata),
        )

    def _copy_message(self, message: Message) -> None:
        self._say_until(message.log_time)
        if message.channel_id not in self._dropped:
            number, times = (
                self._channels[message.channel_id],
                (message.publish_time, message.sequence),
            )
            self._writer.add_message(number, message.log_time, message.data, *times)

    def _say_until(self, log_ns: int | None) -> None:
        """Write what was said before a time; None: all the rest."""
        while self._next is not None and (log_ns is None or self._next.log_ns < log_ns):
            said, self._next = self._next, next(self._said, None)
            number = self._own_channel(said)
            self._writer.add_message(
                number, said.log_ns, said.payload, said.publish_ns, self._number
            )
            self._number += 1

    def _own_channel(self, said: StreamMessage) -> int:
        """The channel of the topic, with what the recorded one says of itself."""
        if self._own is None:
            stream, schema = said.stream, 0
            if stream.schema_encoding:
                wanted = stream.type_name, stream.schema_encoding, stream.schema
                schema = self._writer.register_schema(*wanted)
            about = {} if self._recorded is None else dict(self._recorded.metadata)
            self._own = self._writer.register_channel(self._topic, stream.encoding, schema, about)
        return self._own


def _recorded(found: Survey, topic: str) -> Channel | None:
    """The first channel of a topic."""
    records = whole_records(found.path, found.intact_size, found.size)
    return next((r for r in records if isinstance(r, Channel) and r.topic == topic), None)
