"""Recovers a log that was cut off or damaged: what is intact of it becomes a finished log.

A chunk whose CRC does not fit is left out and counted; the log says so, and replay at level `node`
refuses it, because an input may be missing. The result is read back to check it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Chunk, McapRecord, Message

from reflexarc_logs.container.copying import MessageCopier
from reflexarc_logs.container.first_look import Survey, survey
from reflexarc_logs.container.record_stream import (
    DamagedError,
    TruncatedError,
    stream_records,
    unpack,
)
from reflexarc_logs.container.writing import END, LogWriter, media_type_of
from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.errors import LogError

UNFINISHED = ".recovering"
"""Not the recorder's suffix: `log.mcap.partial` is recovered to `log.mcap`, and is kept."""


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
        self._copier = MessageCopier(file)

    def run(self) -> None:
        self._copy_head()
        for record in self._records():
            if isinstance(record, Message):
                self.messages += self._copier.copy(record)
            else:
                self._copier.learn(record)
        self._say_what_is_missing()
        self.file.finish()

    def _copy_head(self) -> None:
        for name, document in self._found.metadata.items():
            if name != END:
                self.file.describe(name, document)
        for name, data in self._found.attachments.items():
            self.file.attach(name, media_type_of(name), data)

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
