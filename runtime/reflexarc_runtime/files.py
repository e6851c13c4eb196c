"""Files that are whole or absent: written under a temporary name, then renamed; and read whole, if
they are no larger than whoever reads them can bear.

A recording is written otherwise (`reflexarc_logs.container.writing`): what there is of it when its
process is killed must stay.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_MODE = 0o644
"""Temporary files can be read by nobody else; what they become, by everybody."""
_LFS_POINTER = b"version https://git-lfs.github.com/spec/"


def is_lfs_pointer(head: bytes) -> bool:
    """Whether a file is only the note that Git LFS keeps in place of the real one.

    `git lfs pull` fetches the real file; without Git LFS a clone has the notes alone.

    Args:
        head: the first bytes of the file, 40 or more. Source: the LFS pointer specification, which
            puts this line first.
    """
    return head.startswith(_LFS_POINTER)


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield a temporary file to write to; it becomes `path` at the end, in place of an older file.

    Whoever reads `path` meanwhile meets the old file or the new one, never a part. After an error
    the old file stays and nothing is left beside it.

    Raises:
        OSError: the folder is missing or cannot be written.
    """
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    os.close(handle)
    unfinished = Path(name)
    try:
        yield unfinished
        _make_durable(unfinished)
        unfinished.chmod(_MODE)
        os.replace(unfinished, path)
    finally:
        unfinished.unlink(missing_ok=True)


def read_at_most(path: Path, most_bytes: int) -> bytes:
    """The bytes of a file; of a larger one, or of one without an end, one more than `most_bytes`.

    Raises:
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        return file.read(most_bytes + 1)


def write_atomically(path: Path, data: bytes) -> None:
    """Put `data` at `path` as `whole_file` does, in a folder that is made if it is missing.

    Raises:
        OSError: the folder cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as unfinished:
        unfinished.write_bytes(data)


def _make_durable(path: Path) -> None:
    """Wait until the disk has the data: a power cut must not leave a name without it."""
    with path.open("rb") as file:
        os.fsync(file.fileno())
