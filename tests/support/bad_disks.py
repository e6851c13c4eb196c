"""Files that fail as disks do, for tests of whoever writes to them."""

import errno
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any


class BadFile:
    """A new file; `fails` is asked before each write, with the size after it, and may raise.

    Args:
        path: must not exist.
        fails: raises what the disk would, or does nothing.
    """

    def __init__(self, path: Path, fails: Callable[[int], None]) -> None:
        self._file, self._fails = path.open("xb"), fails

    def write(self, data: bytes) -> int:
        self._fails(self._file.tell() + len(data))
        return self._file.write(data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def full_after(room: int, number: int = errno.ENOSPC) -> Callable[[int], None]:
    """A disk that takes so many bytes, and then refuses by an error number."""

    def fails(size: int) -> None:
        if size > room:
            raise OSError(number, os.strerror(number))

    return fails


class Hanging:
    """A disk that answers no more from the moment on in which it is told to, until released."""

    def __init__(self) -> None:
        self.hangs, self._released = False, threading.Event()

    def __call__(self, _: int) -> None:
        if self.hangs:
            self._released.wait(60.0)

    def release(self) -> None:
        self._released.set()


class Disks:
    """Stands in for `open_for_writing`: each new file gets the next disk; the rest are good.

    Args:
        fails: what each disk raises, in the order in which files are opened.
    """

    def __init__(self, *fails: Callable[[int], None]) -> None:
        self._fails = list(fails)

    def __call__(self, path: Path) -> Any:
        return BadFile(path, self._fails.pop(0)) if self._fails else path.open("xb")
