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
from mcap.writer import CompressionType, Writer
from mcap_protobuf.schema import build_file_descriptor_set

from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import NO_SENDER

CHUNK_BYTES = 64 * 1024
PARTIAL = ".partial"
PROFILE = "reflexarc"

POLICY_ATTACHMENT = "policy.onnx"
CONFIG_ATTACHMENT = "config.json"
END = "reflexarc.end"
"""Metadata written last, where something is missing: how many records, how many chunks."""

SENDER = "reflexarc.sender"
"""Metadata of a channel: the identifier of whoever sent its messages, in hexadecimal."""
NO_METADATA: Mapping[str, str] = {}

_CANNOT_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)
"""Not every file system can be told to sync."""
_MEDIA_TYPES = {".onnx": "application/onnx", ".json": "application/json"}


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
        self._file = _open(path, self.partial)
        self._writer = Writer(
            self._file,
            chunk_size=chunk_bytes or CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_crcs=True,
            enable_data_crcs=True,
        )
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str, str], int] = {}
        self._writer.start(profile=PROFILE)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment, without a time: it is true of the whole run."""
        self._writer.add_attachment(0, 0, name, media_type, data)

    def describe(self, name: str, document: Mapping[str, str]) -> None:
        """Write a metadata record."""
        self._writer.add_metadata(name, dict(document))

    def channel(self, topic: str, kind: type[ProtobufMessage], sender: bytes = NO_SENDER) -> int:
        """The channel of a topic that carries this protobuf message from this sender."""
        name, who = kind.DESCRIPTOR.full_name, sender.hex()
        if (topic, name, who) in self._channels:
            return self._channels[topic, name, who]
        descriptors = build_file_descriptor_set(kind).SerializeToString()
        return self.raw_channel(topic, name, "protobuf", descriptors, {SENDER: who})

    def raw_channel(
        self,
        topic: str,
        schema: str,
        encoding: str,
        descriptors: bytes,
        metadata: Mapping[str, str] = NO_METADATA,
    ) -> int:
        """The channel of a topic, its schema given as it stands in a log."""
        place = (topic, schema, metadata.get(SENDER, ""))
        if place not in self._channels:
            if schema not in self._schemas:
                registered = self._writer.register_schema(schema, encoding, descriptors)
                self._schemas[schema] = registered
            self._channels[place] = self._writer.register_channel(
                topic, encoding, self._schemas[schema], dict(metadata)
            )
        return self._channels[place]

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
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            if error.errno not in _CANNOT_SYNC:
                raise

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
        if os.path.lexists(self.path):
            raise FileExistsError(17, "appeared during the recording", str(self.path))
        self.partial.rename(self.path)

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


def _open(path: Path, partial: Path) -> BinaryIO:
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
