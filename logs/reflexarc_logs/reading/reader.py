"""Reads a log: checks it when it is opened, then streams its messages in file order.

File order is the order in which the loop used its inputs, and the only one that replay may use: a
reader that sorts by time could put an input after the tick that used it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from google.protobuf.descriptor import Descriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Schema
from mcap.records import Message as McapMessage

from reflexarc_logs.container.chunks import records_in
from reflexarc_logs.container.fields import MESSAGE, decoded
from reflexarc_logs.container.first_look import Survey, survey
from reflexarc_logs.container.frames import DamagedError, NotReadHereError
from reflexarc_logs.container.record_stream import ChunkBytes, whole_parts, whole_records
from reflexarc_logs.container.remedy import recovery
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, POLICY_ATTACHMENT, SENDER
from reflexarc_logs.reading.channels import Channels
from reflexarc_logs.reading.message_tables import MessageTable, tables_of
from reflexarc_logs.reading.record import Record
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.messages_pb2 import Tick

__all__ = ["Log", "Record", "decode", "open_log", "read_log"]

M = TypeVar("M", bound=ProtobufMessage)
T = TypeVar("T")


@dataclass(frozen=True)
class Log:
    """A log that was checked; every iteration reads the file anew, in its order."""

    path: Path
    run: RunInfo
    attachments: Mapping[str, bytes]
    """`policy.onnx`, `config.json` and what other tools attached; read when they are asked for."""
    complete: bool
    """Whether the log was finished; a truncated one ends at its last intact record."""
    metadata: Mapping[str, Mapping[str, str]]
    """All that the log says about itself, by name of the record."""
    dropped: int
    """Records or chunks that are missing in the middle, as the recorder or `recover` said."""
    size: int
    """Bytes of the file."""
    intact_size: int
    """Bytes up to the end of the last intact record."""

    @property
    def policy(self) -> bytes | None:
        """The attached policy file."""
        return self.attachments.get(POLICY_ATTACHMENT)

    @property
    def config(self) -> bytes | None:
        """The attached configuration, JSON."""
        return self.attachments.get(CONFIG_ATTACHMENT)

    def topic(self, name: str) -> str:
        """The topic in this log for a name of the topic table: "retina" → "/robot0/retina"."""
        return f"/{self.run.robot}/{name}"

    def records(self, *topics: str) -> Iterator[Record]:
        """Records in file order; of these topics ("/robot0/retina"), or of all.

        Raises:
            LogError: a chunk is damaged (in a truncated log, reading ends there instead).
        """
        channels = Channels(self.path, self.run.publish_shift_ns)
        yield from self._checked(_records(self._parts(), channels, topics))

    def tables(self) -> Iterator[MessageTable]:
        """All messages in file order, many at once.

        Raises:
            LogError: see `records`.
        """
        yield from self._checked(
            tables_of(self._parts(), Channels(self.path, self.run.publish_shift_ns))
        )

    def messages(self, topic: str, kind: type[M]) -> Iterator[tuple[Record, M]]:
        """Records of one topic, decoded.

        Raises:
            LogError: a payload is no such message, or a chunk is damaged.
        """
        for record in self.records(topic):
            yield record, decode(self, record, kind)

    def ticks(self) -> Iterator[Tick]:
        """The ticks, in order."""
        for _, tick in self.messages(self.topic(TICK.name), Tick):
            yield tick

    def tick_descriptor(self) -> Descriptor:
        """The descriptor of `reflexarc.Tick` that the log itself carries.

        Raises:
            LogError: the log has none, or a malformed one.
        """
        found = self.descriptor(TICK.schema)
        if found is None:
            raise LogError(
                f"{self.path}: expected ticks ({TICK.schema}), found none; nothing to replay"
            )
        return found

    def descriptor(self, schema: str) -> Descriptor | None:
        """The descriptor of a message that the log itself carries; None if it has none.

        Raises:
            LogError: a malformed one.
        """
        for record in self.mcap_records():
            if isinstance(record, Schema) and record.name == schema:
                return _descriptor(record, self.path)
        return None

    @cached_property
    def names_senders(self) -> bool:
        """Whether any channel says who sent its messages; other tools may drop that."""
        records = self.mcap_records()
        return any(isinstance(r, Channel) and SENDER in r.metadata for r in records)

    def mcap_records(self) -> Iterator[McapRecord]:
        """Every record, chunks unpacked; ends quietly where a truncated log is no longer intact."""
        yield from self._checked(whole_records(self.path, self.intact_size, self.size))

    def _parts(self) -> Iterator[McapRecord | ChunkBytes]:
        return whole_parts(self.path, self.intact_size, self.size)

    def _checked(self, read: Iterator[T]) -> Iterator[T]:
        """What is read from the file; what is wrong with it, in the words of this package."""
        try:
            yield from read
        except DamagedError as error:
            if self.complete:
                advice = f"{recovery(self.path)} saves the rest"
                raise LogError(f"{self.path}: damaged: {error}; {advice}") from None
        except NotReadHereError as error:
            raise LogError(f"{self.path}: {error}") from None
        except OSError as error:
            raise LogError(f"{self.path}: cannot be read: {error.strerror}") from None


def read_log(path: Path | str, *, allow_truncated: bool = False) -> Log:
    """Open a log: one pass over the file checks its frame and its CRC.

    Args:
        path: an MCAP file that reflexarc recorded.
        allow_truncated: whether to accept a log that was never finished.

    Raises:
        LogError: it is missing, empty, not MCAP, damaged, truncated, or of another system.
    """
    found = survey(Path(path))
    if not found.complete and not allow_truncated:
        raise LogError(
            f"{path}: expected a finished log, got a truncated one ({found.damage}); "
            f"{recovery(path)} saves what is there"
        )
    return open_log(found)


def decode(log: Log, record: Record, kind: type[M]) -> M:
    """Decode one record.

    Raises:
        LogError: the payload is no such message.
    """
    name = kind.DESCRIPTOR.full_name
    try:
        if record.schema == name:
            return kind.FromString(record.payload)
    except DecodeError:
        pass
    raise LogError(f"{log.path}: {record.topic}: expected {name}, got something else; damaged?")


def _records(
    parts: Iterator[McapRecord | ChunkBytes], channels: Channels, topics: tuple[str, ...]
) -> Iterator[Record]:
    """The messages of some topics, or of all, without an object for each of the others."""
    for part in parts:
        if isinstance(part, ChunkBytes):
            yield from _records_in(part, channels, topics)
        elif isinstance(part, McapMessage):
            stream = channels.of(part.channel_id)
            if not topics or stream.topic in topics:
                sent_ns = max(0, part.publish_time - channels.publish_shift_ns)
                times = part.sequence, part.log_time, sent_ns
                yield Record(stream.topic, stream.schema, *times, part.data, stream.sender)
        else:
            channels.learn(part)


def _records_in(chunk: ChunkBytes, channels: Channels, topics: tuple[str, ...]) -> Iterator[Record]:
    content, streams, head = chunk.content, channels.streams, MESSAGE.size
    shift_ns = channels.publish_shift_ns
    for opcode, start, end in records_in(content, chunk.allowance):
        if opcode == Opcode.MESSAGE:
            if end - start < head:
                raise DamagedError("a record shorter than its own fields")
            channel, sequence, log_ns, sent_ns = MESSAGE.unpack_from(content, start)
            topic, schema, sender = streams.get(channel) or channels.of(channel)
            if not topics or topic in topics:
                payload = content[start + head : end]
                sent_ns = max(0, sent_ns - shift_ns)
                yield Record(topic, schema, sequence, log_ns, sent_ns, payload, sender)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            record = decoded(opcode, content[start:end])
            assert record is not None
            channels.learn(record)


def open_log(found: Survey) -> Log:
    """The log of which this is the first look.

    Raises:
        LogError: what it says of its run is malformed.
    """
    return Log(
        path=found.path,
        run=found.run,
        attachments=found.attachments,
        complete=found.complete,
        metadata=found.metadata,
        dropped=found.dropped,
        size=found.size,
        intact_size=found.intact_size,
    )


def _descriptor(schema: Schema, path: Path) -> Descriptor:
    pool = DescriptorPool()
    try:
        for file in FileDescriptorSet.FromString(schema.data).file:
            pool.Add(file)
        return pool.FindMessageTypeByName(schema.name)
    except (DecodeError, TypeError, KeyError, ValueError) as error:
        reason = " ".join(str(error).split())[:120]
        raise LogError(f"{path}: the schema of {schema.name} is malformed: {reason}") from None
