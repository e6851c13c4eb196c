"""A lock that a living process holds on a file, and that ends with it, however it ends.

See flock(2): it belongs to the open file, and the kernel lets go of it when the process is gone.
"""

import fcntl
import os
from pathlib import Path
from typing import Self


class FileLock:
    """Held until it is closed.

    Args:
        descriptor: of the open file; closed with it.
        is_sure: whether the file system has such locks at all.
    """

    def __init__(self, descriptor: int, *, is_sure: bool) -> None:
        self._descriptor: int | None = descriptor
        self.is_sure = is_sure

    @classmethod
    def made(cls, path: Path) -> Self | None:
        """Make the file, and lock it; None: the name is taken.

        Raises:
            OSError: it cannot be made.
        """
        try:
            return cls._locked(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
        except FileExistsError:
            return None

    @classmethod
    def taken(cls, path: Path) -> Self | None:
        """Lock a file that is there; None: somebody holds it, or nobody can tell.

        Raises:
            OSError: it cannot be opened.
        """
        lock = cls._locked(path, os.O_RDONLY | os.O_NOFOLLOW)
        if lock is not None and not lock.is_sure:
            lock.close()
            return None
        return lock

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of it; a second call does nothing."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)

    @classmethod
    def _locked(cls, path: Path, flags: int) -> Self | None:
        descriptor = os.open(path, flags | os.O_CLOEXEC, 0o666)
        lock = cls(descriptor, is_sure=True)
        try:
            lock.is_sure = hold(descriptor)
        except BlockingIOError:
            lock.close()
            return None
        if not _is_still(path, descriptor):
            lock.close()  # between the two somebody removed it
            return None
        return lock


def hold(descriptor: int) -> bool:
    """Lock an open file for as long as it is open; whether its file system has locks.

    Raises:
        BlockingIOError: somebody else holds it.
    """
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError:
        return False
    return True


def is_held(path: Path) -> bool:
    """Whether a living process holds a lock on a file."""
    try:
        with path.open("rb") as file:
            hold(file.fileno())
    except BlockingIOError:
        return True
    except OSError:  # it is gone, or cannot be read
        pass
    return False


def _is_still(path: Path, descriptor: int) -> bool:
    try:
        return os.path.samestat(os.stat(path, follow_symlinks=False), os.fstat(descriptor))
    except OSError:
        return False
