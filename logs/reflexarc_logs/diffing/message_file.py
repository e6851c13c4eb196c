"""Anybody's MCAP file as streams of messages: one for each topic, in file order."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.records import Channel, Chunk, McapRecord, Metadata, Schema

from reflexarc_logs.container.chunks import Allowance, content_of
from reflexarc_logs.container.first_look import check_is_no_folder, check_is_no_pointer
from reflexarc_logs.container.frames import (
    DamagedError,
    NotMcapError,
    NotReadHereError,
    TruncatedError,
)
from reflexarc_logs.container.record_stream import ChunkBytes, stream_records
from reflexarc_logs.container.remedy import recovery
from reflexarc_logs.container.run_info import RUN, RunInfo
from reflexarc_logs.reading.channels import Channels
from reflexarc_logs.reading.message_tables import MessageTable, tables_of
from reflexarc_runtime.errors import LogError


class Stream(NamedTuple):
    """All messages of a channel."""

    topic: str
    """As the file names it; with `#2` where another channel of the file has the topic as well."""
    type_name: str
    """Of the messages: "reflexarc.Tick", "sensor_msgs/msg/LaserScan"; may be empty."""
    encoding: str
    """Of the messages: "protobuf", "cdr", "json" or another one."""
    schema_encoding: str
    schema: bytes


class StreamMessage(NamedTuple):
    """One message of a stream; times in nanoseconds."""

    stream: Stream
    sequence: int
    log_ns: int
    publish_ns: int
    payload: bytes


class StreamTable(NamedTuple):
    """Many messages at once, in file order."""

    table: MessageTable
    streams: dict[int, Stream]
    """By the channel's number in the table."""


class MessageFile:
    """An MCAP file that is read as often as its streams are wanted.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.was_cut = False
        """Whether it ended in the middle when it was last read to its end."""

    def messages(self) -> Iterator[StreamMessage]:
        """Every message, in file order.

        Raises:
            LogError: it is missing, damaged, or no MCAP file.
        """
        for one in self.tables():
            yield from _messages_of(one)

    def tables(self) -> Iterator[StreamTable]:
        """The same, many at once, for who needs no object for each.

        Raises:
            LogError: it is missing, damaged, or no MCAP file.
        """
        channels = _StreamChannels(self.path)
        check_is_no_folder(self.path)
        try:
            with self.path.open("rb") as file:
                check_is_no_pointer(self.path, file)
            for table in tables_of(self._parts(), channels):
                yield StreamTable(table, channels.by_number)
        except NotMcapError:
            raise LogError(f"{self.path}: expected an MCAP file, got another kind") from None
        except DamagedError as error:
            advice = f"{recovery(self.path)} saves the rest"
            raise LogError(f"{self.path}: damaged: {error}; {advice}") from None
        except NotReadHereError as error:
            raise LogError(f"{self.path}: {error}") from None
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read: {error.strerror}") from None

    def _parts(self) -> Iterator[McapRecord | ChunkBytes]:
        """The records of the file; its chunks as they are when unpacked."""
        allowance = Allowance.of(self.path.stat().st_size)
        try:
            for located in stream_records(self.path):
                if isinstance(located.record, Chunk):
                    yield ChunkBytes(content_of(located.record, allowance), allowance)
                else:
                    yield located.record
        except TruncatedError:
            self.was_cut = True


def _messages_of(one: StreamTable) -> Iterator[StreamMessage]:
    table = one.table
    heads, content, shift_ns = table.heads, table.content, table.publish_shift_ns
    places = zip(table.payloads.tolist(), table.ends.tolist(), strict=True)
    sent_ns = heads["sent_ns"].tolist()
    return map(
        StreamMessage,
        map(one.streams.__getitem__, heads["channel"].tolist()),
        heads["sequence"].tolist(),
        heads["log_ns"].tolist(),
        [sent - shift_ns for sent in sent_ns] if shift_ns else sent_ns,
        [content[start:end] for start, end in places],
    )


def _publish_shift_ns(run: Metadata) -> int:
    """What a log of ours adds to its senders' stamps; of a damaged one nothing."""
    try:
        return RunInfo.from_metadata(run.metadata).publish_shift_ns
    except LogError:
        return 0


class _StreamChannels(Channels):
    """The streams of the channels read so far, by the channels' numbers."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.by_number: dict[int, Stream] = {}
        self._known: dict[int, Schema] = {}
        self._times: Counter[str] = Counter()

    def learn(self, record: McapRecord) -> None:
        """Take a record; those behind the messages repeat what was said before them."""
        super().learn(record)
        if isinstance(record, Metadata) and record.name == RUN:
            self.publish_shift_ns = _publish_shift_ns(record)
        elif isinstance(record, Schema):
            self._known.setdefault(record.id, record)
        elif isinstance(record, Channel) and record.id not in self.by_number:
            self.by_number[record.id] = self._stream(record)

    def _stream(self, channel: Channel) -> Stream:
        self._times[channel.topic] += 1
        occurrence = self._times[channel.topic]
        topic = channel.topic if occurrence == 1 else f"{channel.topic}#{occurrence}"
        schema = self._known.get(channel.schema_id)
        if schema is None:
            return Stream(topic, "", channel.message_encoding, "", b"")
        return Stream(topic, schema.name, channel.message_encoding, schema.encoding, schema.data)
