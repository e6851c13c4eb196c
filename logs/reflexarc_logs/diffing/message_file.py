"""Anybody's MCAP file as streams of messages: one for each topic, in file order."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Metadata, Schema

from reflexarc_logs.container.chunks import Allowance, content_of, records_in
from reflexarc_logs.container.fields import MESSAGE, decoded
from reflexarc_logs.container.first_look import check_is_no_pointer
from reflexarc_logs.container.frames import (
    DamagedError,
    NotMcapError,
    NotReadHereError,
    TruncatedError,
)
from reflexarc_logs.container.record_stream import stream_records
from reflexarc_logs.container.remedy import recovery
from reflexarc_logs.container.run_info import RUN, RunInfo
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


class MessageFile:
    """An MCAP file that is read as often as its streams are wanted.

    Args:
        path: the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._allowance = Allowance.of(0)
        self._publish_shift_ns = 0
        self.was_cut = False
        """Whether it ended in the middle when it was last read to its end."""

    def messages(self) -> Iterator[StreamMessage]:
        """Every message, in file order.

        Raises:
            LogError: it is missing, damaged, or no MCAP file.
        """
        channels = _Channels()
        try:
            with self.path.open("rb") as file:
                check_is_no_pointer(self.path, file)
            self._allowance = Allowance.of(self.path.stat().st_size)
            for located in stream_records(self.path):
                record = located.record
                if isinstance(record, Chunk):
                    yield from self._in_chunk(record, channels)
                elif isinstance(record, Message):
                    sent_ns = record.publish_time - self._publish_shift_ns
                    times = record.sequence, record.log_time, sent_ns
                    yield StreamMessage(channels.of(record.channel_id), *times, record.data)
                elif isinstance(record, Metadata) and record.name == RUN:
                    self._publish_shift_ns = _publish_shift_ns(record)
                elif isinstance(record, Schema | Channel):
                    channels.learn(record)
        except TruncatedError:
            self.was_cut = True
        except NotMcapError:
            raise LogError(f"{self.path}: expected an MCAP file, got another kind") from None
        except DamagedError as error:
            advice = f"{recovery(self.path)} saves the rest"
            raise LogError(f"{self.path}: damaged: {error}; {advice}") from None
        except NotReadHereError as error:
            raise LogError(f"{self.path}: {error}") from None
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read: {error.strerror}") from None

    def _in_chunk(self, chunk: Chunk, channels: "_Channels") -> Iterator[StreamMessage]:
        """Its messages, without an object of the library for each: most are only passed on."""
        content, streams = content_of(chunk, self._allowance), channels.streams
        for opcode, start, end in records_in(content, self._allowance):
            if opcode == Opcode.MESSAGE:
                channel, sequence, log_ns, sent_ns = MESSAGE.unpack_from(content, start)
                stream = streams.get(channel) or channels.of(channel)
                payload = content[start + MESSAGE.size : end]
                sent_ns -= self._publish_shift_ns
                yield StreamMessage(stream, sequence, log_ns, sent_ns, payload)
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                record = decoded(opcode, content[start:end])
                assert isinstance(record, Schema | Channel)
                channels.learn(record)


def _publish_shift_ns(run: Metadata) -> int:
    """What a log of ours adds to its senders' stamps; of a damaged one nothing."""
    try:
        return RunInfo.from_metadata(run.metadata).publish_shift_ns
    except LogError:
        return 0


class _Channels:
    """The streams of the channels read so far, by the channels' numbers."""

    def __init__(self) -> None:
        self.streams: dict[int, Stream] = {}
        self._schemas: dict[int, Schema] = {}
        self._times: Counter[str] = Counter()

    def learn(self, record: Schema | Channel) -> None:
        """Take a record; those behind the messages repeat what was said before them."""
        if isinstance(record, Schema):
            self._schemas.setdefault(record.id, record)
        elif record.id not in self.streams:
            self.streams[record.id] = self._stream(record)

    def of(self, channel_id: int) -> Stream:
        """The stream of a channel.

        Raises:
            DamagedError: nothing says what it is.
        """
        if channel_id not in self.streams:
            raise DamagedError("a message on an unknown channel")
        return self.streams[channel_id]

    def _stream(self, channel: Channel) -> Stream:
        self._times[channel.topic] += 1
        occurrence = self._times[channel.topic]
        topic = channel.topic if occurrence == 1 else f"{channel.topic}#{occurrence}"
        schema = self._schemas.get(channel.schema_id)
        if schema is None:
            return Stream(topic, "", channel.message_encoding, "", b"")
        return Stream(topic, schema.name, channel.message_encoding, schema.encoding, schema.data)
