"""Writes one MCAP file, which is named `PATH.partial` until it is finished, then `PATH`.

The library's writer says neither how thoroughly a chunk is compressed nor what a kill costs; this
one writes the same records (a test compares the bytes). Chunks are small (64 KiB): what a killed
recording loses is the last one.
"""

from collections.abc import Mapping
from pathlib import Path

from google.protobuf.message import Message as ProtobufMessage
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, Schema
from mcap.writer import LIBRARY_IDENTIFIER

from reflexarc_logs.container.attachments import Attached
from reflexarc_logs.container.frames import HEAD
from reflexarc_logs.container.packing.compression import Compressor, FixedCompressor
from reflexarc_logs.container.packing.open_chunk import OpenChunk
from reflexarc_logs.container.packing.schemas import NO_SCHEMA, PROTOBUF, schema_of
from reflexarc_logs.container.raw_log import RawLog, bytes_of
from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_runtime.messages.wire import NO_SENDER

CHUNK_BYTES = 64 * 1024
PROFILE = "reflexarc"

POLICY_ATTACHMENT = "policy.onnx"
ATTACHED_BESIDE = "policy-"
"""How the names of attached policies begin that decided later, or watched."""
CONFIG_ATTACHMENT = "config.json"
END = "reflexarc.end"
"""Metadata written last, where something is missing: how many records, how many chunks."""

SENDER = "reflexarc.sender"
"""Metadata of a channel: the identifier of whoever sent its messages, in hexadecimal."""
NO_METADATA: Mapping[str, str] = {}

_MEDIA_TYPES = {".onnx": "application/onnx", ".json": "application/json"}


def attachment_of(policy_hash: str) -> str:
    """What a policy beside the first one is attached as."""
    return f"{ATTACHED_BESIDE}{policy_hash}.onnx"


class LogWriter:
    """An MCAP file that one thread writes.

    Args:
        path: its name when it is finished.
        unfinished: what is added to the name until then.
        chunk_bytes: size after which a chunk is compressed and written; None: `CHUNK_BYTES`.
        compressor: of the chunks; None: a thorough one.

    Raises:
        LogError: something of that name is there already, or the place cannot be written.
    """

    def __init__(
        self,
        path: Path,
        unfinished: str = PARTIAL,
        chunk_bytes: int | None = None,
        compressor: Compressor | None = None,
    ) -> None:
        self._log = RawLog(path, unfinished)
        self.file = self._log.file
        """The file itself: its names, its descriptor, how it is synced and given up."""
        self._chunk = OpenChunk()
        self._chunk_bytes = chunk_bytes or CHUNK_BYTES
        self._compressor = FixedCompressor() if compressor is None else compressor
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[tuple[str, str, bytes], int] = {}
        self._raw_channels: dict[tuple[str, str, int, tuple[tuple[str, str], ...]], int] = {}
        header = Header(PROFILE, LIBRARY_IDENTIFIER)
        self._log.record(Opcode.HEADER, bytes_of(header)[HEAD.size :])

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, without a time: it is true of the whole run."""
        record = Attachment(log_time=0, create_time=0, name=name, media_type=media_type, data=data)
        fields = bytes_of(record)[HEAD.size :]
        attached = Attached(name, media_type, 0, 0, data=0, size=len(data), crc=0)
        self._log.attachment(attached, len(fields), [fields])

    def describe(self, name: str, document: Mapping[str, str]) -> None:
        """Write a metadata record."""
        self._log.describe(name, {key: _in_utf8(text) for key, text in document.items()})

    def channel(self, topic: str, kind: type[ProtobufMessage], sender: bytes = NO_SENDER) -> int:
        """The channel of a topic that carries this protobuf message from this sender."""
        place = (topic, kind.DESCRIPTOR.full_name, sender)
        if place not in self._channels:
            self._channels[place] = self.raw_channel(
                topic, PROTOBUF, schema_of(kind), {SENDER: sender.hex()}
            )
        return self._channels[place]

    def raw_channel(
        self,
        topic: str,
        encoding: str,
        schema: Schema | None,
        metadata: Mapping[str, str] = NO_METADATA,
    ) -> int:
        """The channel of a topic as it stands in a log.

        Args:
            topic: with its leading slash.
            encoding: of the messages; the schema has one of its own.
            schema: None: the messages have none.
            metadata: of the channel.
        """
        schema_id = NO_SCHEMA if schema is None else self._schema(schema)
        place = (topic, encoding, schema_id, tuple(metadata.items()))
        if place not in self._raw_channels:
            number = len(self._raw_channels) + 1
            channel = Channel(
                id=number,
                topic=topic,
                message_encoding=encoding,
                metadata=dict(metadata),
                schema_id=schema_id,
            )
            self._define(Opcode.CHANNEL, number, bytes_of(channel)[HEAD.size :])
            self._raw_channels[place] = number
        return self._raw_channels[place]

    def _schema(self, schema: Schema) -> int:
        """The number of a schema in this file; its number elsewhere does not matter."""
        place = (schema.name, schema.encoding, schema.data)
        if place not in self._schemas:
            number = len(self._schemas) + 1
            numbered = Schema(number, schema.data, schema.encoding, schema.name)
            self._define(Opcode.SCHEMA, number, bytes_of(numbered)[HEAD.size :])
            self._schemas[place] = number
        return self._schemas[place]

    def _define(self, opcode: int, number: int, fields: bytes) -> None:
        self._log.define(opcode, number, fields, is_written=False)
        self._chunk.define(opcode, fields)
        self._close_full()

    def add(
        self, channel: int, payload: bytes, *, sequence: int, publish_ns: int, log_ns: int
    ) -> None:
        """Write one message; times in nanoseconds, not negative."""
        self._chunk.message(
            channel, payload, sequence=sequence, publish_ns=publish_ns, log_ns=log_ns
        )
        self._close_full()

    def flush(self) -> None:
        """Hand to the system all that was added: what a killed process does not lose."""
        self._close()
        self.file.flush()

    def finish(self) -> None:
        """Write the index, make the file durable and give it its name."""
        self.seal()
        self.file.settle()

    def seal(self) -> None:
        """Write the index; nothing can be added any more."""
        self._close()
        self._log.seal()

    def end(self) -> None:
        """Write the index, make the file durable and close it; it keeps the name `partial`."""
        self.seal()
        self.file.end()

    def discard(self) -> None:
        """Close the file and remove it."""
        self.file.discard()

    def _close_full(self) -> None:
        if self._chunk.size_bytes > self._chunk_bytes:
            self._close()

    def _close(self) -> None:
        """Compress the open chunk and write it; schemas alone wait for a message."""
        if self._chunk.has_messages:
            self._log.chunk(*self._chunk.taken(self._compressor))


def media_type_of(attachment: str) -> str:
    """Media type of an attachment, by its name."""
    return _MEDIA_TYPES.get(Path(attachment).suffix, "application/octet-stream")


def _in_utf8(text: str) -> str:
    """Text with an escape for each byte of a file's name that is no character."""
    return text.encode("utf-8", "backslashreplace").decode()
