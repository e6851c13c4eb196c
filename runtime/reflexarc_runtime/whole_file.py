"""A file that is there whole or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from reflexarc_runtime.errors import UsageError

UNFINISHED = ".unfinished"


def check_place(path: Path) -> None:
    """Refuse a place where no file can be, before any work is done for it.

    Raises:
        UsageError: its folder is missing, or it is a folder itself.
    """
    if path.is_dir():
        raise UsageError(f"--out: expected the name of a file, got the folder {path}")
    if not path.parent.is_dir():
        raise UsageError(f"--out: {path}: no such folder: {path.parent}; make it first")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Where to write meanwhile; at the end it takes the name of `path`, after a failure it goes."""
    unfinished = path.with_name(path.name + UNFINISHED)
    try:
        yield unfinished
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
