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
from mcap.records import Channel, McapRecord, Schema
from mcap.records import Message as McapMessage

from reflexarc_logs.container.first_look import Survey, survey
from reflexarc_logs.container.frames import DamagedError, NotReadHereError
from reflexarc_logs.container.record_stream import whole_records
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, POLICY_ATTACHMENT, SENDER
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.messages.wire import NO_SENDER, SENDER_BYTES
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.words.suggestion import pasteable

M = TypeVar("M", bound=ProtobufMessage)


@dataclass(frozen=True, slots=True)
class Record:
    """One message as the log holds it. Times in nanoseconds."""

    topic: str
    """With a leading slash: "/robot0/retina"."""
    schema: str
    """Full name of the protobuf message."""
    sequence: int
    log_ns: int
    """Arrival: the recorder's monotonic clock plus `RunInfo.wall_offset_ns`."""
    publish_ns: int
    """On the sender's clock."""
    payload: bytes
    sender: bytes = NO_SENDER
    """Who sent it: 16 bytes; zeros in logs that do not say."""


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
        channels, shift_ns = _Channels(), self.run.publish_shift_ns
        for record in self.mcap_records():
            if isinstance(record, McapMessage):
                stream = channels.of(record, self.path)
                if not topics or stream.topic in topics:
                    yield _record(stream, record, shift_ns)
            else:
                channels.learn(record)

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
        try:
            yield from whole_records(self.path, self.intact_size, self.size)
        except DamagedError as error:
            if self.complete:
                raise LogError(f"{self.path}: damaged: {error}; `reflexarc recover` it") from None
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
            f"`{pasteable('reflexarc', 'recover', path)} -o FIXED.mcap` saves what is there"
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


@dataclass(frozen=True, slots=True)
class _Stream:
    """What all messages of a channel have in common."""

    topic: str
    schema: str
    sender: bytes


class _Channels:
    """The channels and schemas read so far."""

    def __init__(self) -> None:
        self._schemas: dict[int, str] = {}
        self._streams: dict[int, _Stream] = {}

    def learn(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            schema = self._schemas.get(record.schema_id, "")
            self._streams[record.id] = _Stream(record.topic, schema, _sender(record))

    def of(self, message: McapMessage, path: Path) -> _Stream:
        stream = self._streams.get(message.channel_id)
        if stream is None:
            raise LogError(f"{path}: a message on an unknown channel; `reflexarc recover` it")
        return stream


def _record(stream: _Stream, message: McapMessage, shift_ns: int) -> Record:
    return Record(
        topic=stream.topic,
        schema=stream.schema,
        sequence=message.sequence,
        log_ns=message.log_time,
        publish_ns=max(0, message.publish_time - shift_ns),
        payload=message.data,
        sender=stream.sender,
    )


def _sender(channel: Channel) -> bytes:
    """The identifier in a channel's metadata; of a damaged one none."""
    text = channel.metadata.get(SENDER, "")
    try:
        return bytes.fromhex(text).ljust(SENDER_BYTES, b"\0")[:SENDER_BYTES]
    except ValueError:
        return NO_SENDER


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
