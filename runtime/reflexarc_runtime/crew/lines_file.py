"""A file of results: one line of JSON each, flushed to the disk at once.

A process that is killed leaves whole lines and at most one incomplete line at the end; reading
skips that line, and the next process that opens the file removes it. A lock keeps other processes
from writing.
"""

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self

from reflexarc_runtime.errors import UsageError


class LinesFile:
    """A file of lines, open for appending; a context manager that closes it.

    Args:
        path: its folder is made if it is missing.
        who: what another process that has it open is called.

    Raises:
        UsageError: another process has it open.
    """

    def __init__(self, path: Path, who: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: BinaryIO = path.open("a+b")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise UsageError(f"{path.parent}: another {who} is running here; wait for it") from None
        self._cut_torn_line()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def append_line(self, plain: dict[str, Any]) -> None:
        """Append a result; it is on the disk when this returns."""
        self._file.write((json.dumps(plain) + "\n").encode())
        self._file.flush()
        os.fsync(self._file.fileno())

    def empty(self) -> None:
        """Begin anew: remove all lines."""
        self._file.truncate(0)

    def _cut_torn_line(self) -> None:
        self._file.seek(0)
        content = self._file.read()
        self._file.truncate(content.rfind(b"\n") + 1)


def read_lines(path: Path) -> list[dict[str, Any]]:
    """The whole lines of a file, in its order; those that are no JSON object are skipped.

    Returns:
        None of them if there is no file.

    Raises:
        OSError: the file exists and cannot be read.
    """
    if not path.exists():
        return []
    lines = map(_object_of, path.read_bytes().split(b"\n")[:-1])
    return [line for line in lines if line is not None]


def _object_of(line: bytes) -> dict[str, Any] | None:
    try:
        found = json.loads(line)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None
