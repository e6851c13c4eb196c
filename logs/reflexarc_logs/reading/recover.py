"""Recovers a log that was cut off or damaged: what is intact of it becomes a finished log.

A chunk whose CRC does not fit is left out and counted; the log says so, and replay at level `node`
refuses it, because an input may be missing. The result is read back to check it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, Chunk, McapRecord, Message, Schema

from reflexarc_logs.container.first_look import Survey, survey
from reflexarc_logs.container.record_stream import (
    DamagedError,
    TruncatedError,
    stream_records,
    unpack,
)
from reflexarc_logs.container.writing import END, LogWriter
from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.errors import LogError

UNFINISHED = ".recovering"
"""Not the recorder's suffix: `log.mcap.partial` is recovered to `log.mcap`, and is kept."""

_MEDIA_TYPES = {".onnx": "application/onnx", ".json": "application/json"}


@dataclass(frozen=True)
class Recovered:
    """What was saved, and what was not."""

    path: Path
    """The finished log."""
    messages: int
    lost_bytes: int
    """Bytes of the broken log that could not be read: its end, and damaged chunks."""
    damaged_chunks: int
    was_complete: bool
    """Whether there was nothing to recover."""


def recover(path: Path | str, out: Path | str) -> Recovered:
    """Write what is intact of a log into a finished one.

    Args:
        path: the log that was cut off, or a `.partial`.
        out: the log to be; it must not exist.

    Raises:
        LogError: it does not say that reflexarc recorded it, or `out` cannot be written.
    """
    found = survey(Path(path), salvage=True)
    rescue = _Rescue(Path(path), found, LogWriter(Path(out), UNFINISHED))
    try:
        rescue.run()
    except OSError as error:
        rescue.file.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing was saved") from None
    except BaseException:
        rescue.file.discard()
        raise
    _verify(Path(out), rescue.messages)
    return Recovered(
        path=Path(out),
        messages=rescue.messages,
        lost_bytes=rescue.lost_bytes,
        damaged_chunks=rescue.damaged_chunks,
        was_complete=found.complete and not rescue.damaged_chunks,
    )


class _Rescue:
    """Copies what is intact from one file to another."""

    def __init__(self, path: Path, found: Survey, file: LogWriter) -> None:
        self.file = file
        self.messages = 0
        self.damaged_chunks = 0
        self.lost_bytes = 0 if found.data_ended else found.size - found.intact_size
        self._path = path
        self._found = found
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def run(self) -> None:
        self._copy_head()
        for record in self._records():
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            elif isinstance(record, Message):
                self._copy(record)
        self._say_what_is_missing()
        self.file.finish()

    def _copy_head(self) -> None:
        for name, document in self._found.metadata.items():
            if name != END:
                self.file.describe(name, document)
        for name, data in self._found.attachments.items():
            media_type = _MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream")
            self.file.attach(name, media_type, data)

    def _records(self) -> Iterator[McapRecord]:
        try:
            for located in stream_records(self._path, self._found.intact_size):
                if isinstance(located.record, Chunk):
                    yield from self._unpack(located.record)
                else:
                    yield located.record
        except (TruncatedError, DamagedError):
            return  # the end of what the survey found intact

    def _unpack(self, chunk: Chunk) -> list[McapRecord]:
        try:
            return unpack(chunk)
        except DamagedError:
            self.damaged_chunks += 1
            self.lost_bytes += len(chunk.data)
            return []

    def _copy(self, message: Message) -> None:
        channel = self._channels.get(message.channel_id)
        schema = None if channel is None else self._schemas.get(channel.schema_id)
        if channel is None or schema is None:
            return  # its channel stood in a damaged chunk, which is counted
        target = self.file.raw_channel(
            channel.topic, schema.name, schema.encoding, schema.data, channel.metadata
        )
        self.file.add(
            target,
            message.data,
            sequence=message.sequence,
            publish_ns=message.publish_time,
            log_ns=message.log_time,
        )
        self.messages += 1

    def _say_what_is_missing(self) -> None:
        missing = dict(self._found.metadata.get(END, {}))
        if self.damaged_chunks:
            missing["damaged_chunks"] = str(self.damaged_chunks)
        if missing:
            self.file.describe(END, missing)


def _verify(out: Path, messages: int) -> None:
    """Read the recovered log back and check how many messages it has."""
    got = sum(1 for _ in read_log(out).records())
    if got != messages:
        raise LogError(f"{out}: expected {messages} messages after recovery, read {got}; keep both")
