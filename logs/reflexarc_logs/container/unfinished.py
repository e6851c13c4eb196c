"""A file that bears another name until it is finished: `PATH.partial`, then `PATH`.

A `.partial` without a process that writes it is what a killed recording left; `reflexarc recover`
makes a log of it. Whoever writes one holds a lock on it.
"""

import contextlib
import errno
import os
from pathlib import Path
from typing import BinaryIO

from reflexarc_logs.container.file_lock import hold
from reflexarc_logs.container.remedy import recovery
from reflexarc_runtime.errors import LogError

PARTIAL = ".partial"

_CANNOT_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)
"""Not every file system can be told to sync."""


class UnfinishedFile:
    """A file that is being written.

    Args:
        path: its name when it is finished.
        unfinished: what is added to the name until then.

    Raises:
        LogError: something of that name is there already, or the place cannot be written.
    """

    def __init__(self, path: Path, unfinished: str = PARTIAL) -> None:
        self.path = path
        self.partial = path.with_name(path.name + unfinished)
        self._file = _created(path, self.partial)

    def write(self, data: bytes) -> None:
        """Write bytes; a killed process loses them until they are flushed."""
        self._file.write(data)

    def flush(self) -> None:
        """Hand to the system all that was written."""
        self._file.flush()

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

    def settle(self) -> None:
        """Make it durable, close it and give it its name.

        Raises:
            OSError: the disk did not take it; something of that name is there by now.
        """
        self.end()
        if os.path.lexists(self.path):
            raise FileExistsError(17, "appeared during the recording", str(self.path))
        self.partial.rename(self.path)

    def end(self) -> None:
        """Make it durable and close it; it keeps the name `partial`."""
        self.sync()
        self._file.close()

    def abandon(self) -> None:
        """Close it as it is."""
        with contextlib.suppress(OSError):  # a full disk refuses the last bytes once more
            self._file.close()

    def discard(self) -> None:
        """Close it and remove it."""
        self.abandon()
        self.partial.unlink(missing_ok=True)


def open_for_writing(partial: Path) -> BinaryIO:
    """Create a file that is not there yet."""
    return partial.open("xb")


def _created(path: Path, partial: Path) -> BinaryIO:
    if os.path.lexists(path):
        raise LogError(f"{path}: exists already; choose another name or remove it")
    try:
        file = open_for_writing(partial)
        with contextlib.suppress(BlockingIOError, ValueError):  # somebody looks just now
            hold(file.fileno())
        return file
    except FileExistsError:
        advice = f"{recovery(partial)} saves what is in it; or remove it"
        if partial.suffix != PARTIAL:
            advice = "what made it was killed; remove it"
        raise LogError(f"{partial}: an unfinished log is there; {advice}") from None
    except OSError as error:
        raise LogError(
            f"{path}: cannot be written: {error.strerror}; choose another place"
        ) from None
