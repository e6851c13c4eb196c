"""Writes one MCAP file, which is named `PATH.partial` until it is finished, then `PATH`.

A `.partial` without a process that writes it is what a killed recording left; `reflexarc recover`
makes a log of it. Chunks are small (64 KiB): closing one stalls the writer for 0.7 ms
where 1 MiB takes 4 to 14 ms, and a chunk is what a killed recording loses.
"""

import contextlib
import errno
import os
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

from google.protobuf.message import Message as ProtobufMessage
from mcap.records import Schema
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import NO_SENDER

CHUNK_BYTES = 64 * 1024
PARTIAL = ".partial"
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
NO_SCHEMA = 0

_CANNOT_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)
"""Not every file system can be told to sync."""
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

    Raises:
        LogError: something of that name is there already, or the place cannot be written.
    """

    def __init__(
        self, path: Path, unfinished: str = PARTIAL, chunk_bytes: int | None = None
    ) -> None:
        self.path = path
        self.partial = path.with_name(path.name + unfinished)
        self._file = open_unfinished(path, self.partial)
        self._writer = Writer(
            self._file,
            chunk_size=chunk_bytes or CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[tuple[str, str, bytes], int] = {}
        self._raw_channels: dict[tuple[str, str, int, tuple[tuple[str, str], ...]], int] = {}
        self._writer.start(profile=PROFILE)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, without a time: it is true of the whole run."""
        self._writer.add_attachment(0, 0, name, media_type, data)

    def describe(self, name: str, document: Mapping[str, str]) -> None:
        """Write a metadata record."""
        self._writer.add_metadata(name, {key: _in_utf8(text) for key, text in document.items()})

    def channel(self, topic: str, kind: type[ProtobufMessage], sender: bytes = NO_SENDER) -> int:
        """The channel of a topic that carries this protobuf message from this sender."""
        place = (topic, kind.DESCRIPTOR.full_name, sender)
        if place not in self._channels:
            self._channels[place] = self.raw_channel(
                topic,
                "protobuf",
                _schema_of(kind),
                {SENDER: sender.hex()},
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
        number = NO_SCHEMA if schema is None else self._schema(schema)
        place = (topic, encoding, number, tuple(metadata.items()))
        if place not in self._raw_channels:
            registered = self._writer.register_channel(topic, encoding, number, dict(metadata))
            self._raw_channels[place] = registered
        return self._raw_channels[place]

    def _schema(self, schema: Schema) -> int:
        """The number of a schema in this file; its number elsewhere does not matter."""
        place = (schema.name, schema.encoding, schema.data)
        if place not in self._schemas:
            self._schemas[place] = self._writer.register_schema(*place)
        return self._schemas[place]

    def add(
        self, channel: int, payload: bytes, *, sequence: int, publish_ns: int, log_ns: int
    ) -> None:
        """Write one message; times in nanoseconds, not negative."""
        self._writer.add_message(channel, log_ns, payload, publish_ns, sequence)

    def flush(self) -> None:
        """Hand to the system all that was added: what a killed process does not lose."""
        self._writer.flush()  # type: ignore[no-untyped-call]  # mcap has no type for it

    def sync(self) -> None:
        """Hand to the disk all that was flushed; a disk that is gone says so only then.

        Raises:
            OSError: the disk did not take it.
        """
        sync(self._file)

    def fileno(self) -> int:
        """Descriptor of the open file."""
        return self._file.fileno()

    def finish(self) -> None:
        """Write the index, make the file durable and give it its name."""
        self.seal()
        self.settle()

    def seal(self) -> None:
        """Write the index; nothing can be added any more."""
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap has no type for it
        self._file.flush()

    def settle(self) -> None:
        """Make a sealed file durable, close it and give it its name; from any thread."""
        self._close_durably()
        give_name(self.partial, self.path)

    def end(self) -> None:
        """Write the index, make the file durable and close it; it keeps the name `partial`."""
        self.seal()
        self._close_durably()

    def abandon(self) -> None:
        """Close the file as it is; the `.partial` stays, for `recover`."""
        with contextlib.suppress(OSError):  # a full disk refuses the last bytes once more
            self._file.close()

    def discard(self) -> None:
        """Close the file and remove it."""
        self.abandon()
        self.partial.unlink(missing_ok=True)

    def _close_durably(self) -> None:
        self.sync()
        self._file.close()


def media_type_of(attachment: str) -> str:
    """Media type of an attachment, by its name."""
    return _MEDIA_TYPES.get(Path(attachment).suffix, "application/octet-stream")


def open_for_writing(partial: Path) -> BinaryIO:
    """Create a file that is not there yet."""
    return partial.open("xb")


def sync(file: BinaryIO) -> None:
    """Hand to the disk all that was flushed; a disk that is gone says so only then.

    Raises:
        OSError: the disk did not take it.
    """
    try:
        os.fsync(file.fileno())
    except OSError as error:
        if error.errno not in _CANNOT_SYNC:
            raise


def give_name(partial: Path, path: Path) -> None:
    """Give a file that is finished and closed its name.

    Raises:
        OSError: something of that name is there, or the folder does not take it.
    """
    if os.path.lexists(path):
        raise FileExistsError(17, "appeared during the recording", str(path))
    partial.rename(path)


def open_unfinished(path: Path, partial: Path) -> BinaryIO:
    """Create the file that will be `path` when it is finished.

    Raises:
        LogError: something of one of the two names is there, or the place cannot be written.
    """
    if os.path.lexists(path):
        raise LogError(f"{path}: exists already; choose another name or remove it")
    try:
        return open_for_writing(partial)
    except FileExistsError:
        advice = "`reflexarc recover` it or remove it"
        if partial.suffix != PARTIAL:
            advice = "what made it was killed; remove it"
        raise LogError(f"{partial}: an unfinished log is there; {advice}") from None
    except OSError as error:
        raise LogError(
            f"{path}: cannot be written: {error.strerror}; choose another place"
        ) from None


def _schema_of(kind: type[ProtobufMessage]) -> Schema:
    """The schema of a protobuf message, with all that it is made of."""
    descriptors = build_file_descriptor_set(kind).SerializeToString()
    return Schema(
        id=NO_SCHEMA, name=kind.DESCRIPTOR.full_name, encoding="protobuf", data=descriptors
    )


def _in_utf8(text: str) -> str:
    """Text with an escape for each byte of a file's name that is no character."""
    return text.encode("utf-8", "backslashreplace").decode()
