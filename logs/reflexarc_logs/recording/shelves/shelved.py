"""A file of a recording that has ended, and how it is removed: only if it is still that file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.container.manifest import PartEvent

BYTES_IN_MB = 1 << 20


@dataclass(frozen=True)
class Shelved:
    """A part that ended, under the name that its file has now."""

    number: int
    name: str
    """Its name when it is finished."""
    path: Path
    size_bytes: int
    identity: tuple[int, int]
    """Device and inode."""


def shelved(number: int, name: str, path: Path) -> Shelved:
    """A part as it is found on the disk.

    Raises:
        OSError: it is not there.
    """
    found = path.stat(follow_symlinks=False)
    return Shelved(number, name, path, found.st_size, (found.st_dev, found.st_ino))


def removed(
    part: Shelved, why: str, is_ours: Callable[[], bool] = lambda: True
) -> tuple[PartEvent, str]:
    """Remove it; what became of it, and why.

    Args:
        part: whose name may lead to another file by now: that one is left alone.
        why: it shall go.
        is_ours: whether what is in it says so as well.
    """
    try:
        found = part.path.stat(follow_symlinks=False)
        if (found.st_dev, found.st_ino) != part.identity or not is_ours():
            return "left", "another file has its name"
        part.path.unlink()
    except FileNotFoundError:
        return "left", "somebody removed or renamed it before"
    except OSError as error:
        return "left", error.strerror or repr(error)
    return "removed", why
