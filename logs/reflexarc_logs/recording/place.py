"""Is a file that is being written still where its name says, and is there room for more?

A deleted file takes every byte without complaint, and so does one whose disk was detached: only a
look at its name tells. Every look compares what the name leads to with what is open, by device and
inode.
"""

import os
import stat
from pathlib import Path

DEFAULT_RESERVE_BYTES = 64 << 20
"""Left free: enough to finish the log, and for a system's own files."""
RESERVED_SHARE = 0.1
"""Of a small disk the reserve is at most this part."""
LEAST_ROOM_BYTES = 1 << 20
"""Nothing new is begun with less room than this, whatever the reserve."""


class LostPlaceError(Exception):
    """The file is no longer where it should be; its one line says what happened."""


class NoRoomError(Exception):
    """Less is free than shall stay free; its one line says how much."""


class Place:
    """Where a log is written.

    Args:
        path: the finished log.
        reserve_bytes: what shall stay free.
    """

    def __init__(self, path: Path, reserve_bytes: int = DEFAULT_RESERVE_BYTES) -> None:
        self._folder = path.parent
        self._reserve_bytes = reserve_bytes
        self._true_folder = path.parent.resolve()
        self._outer_device = _outer_device(self._true_folder)

    def look(self, path: Path, partial: Path, descriptor: int) -> str:
        """Look at the open file and its name.

        Args:
            path: its name when it is finished.
            partial: its name until then.
            descriptor: of the open file.

        Returns:
            What will keep it from getting its name, in words; empty if nothing will.

        Raises:
            LostPlaceError: what is written is in vain, or nobody would find it.
            NoRoomError: less is free than the reserve.
        """
        try:
            named = os.stat(partial, follow_symlinks=False)
        except PermissionError:
            return "its folder cannot be looked into any more"
        except OSError:
            raise LostPlaceError(self._what_happened(descriptor, None)) from None
        if not os.path.samestat(named, os.fstat(descriptor)):
            raise LostPlaceError(self._what_happened(descriptor, named))
        self._check_room(os.fstatvfs(descriptor))
        if os.path.lexists(path):
            return f"another file got the name {path.name}"
        if not os.access(self._folder, os.W_OK | os.X_OK):
            return "its folder cannot be written any more"
        return ""

    def check_ready(self, *, twice: bool = True) -> None:
        """Look whether a new file can be begun.

        Args:
            twice: whether twice the reserve must be free, as after a failure.

        Raises:
            LostPlaceError: the disk is not there.
            NoRoomError: too little is free.
            OSError: the folder is gone and cannot be made anew.
        """
        if self._is_detached():
            raise LostPlaceError("its disk was detached")
        self._folder.mkdir(parents=True, exist_ok=True)
        self._check_room(os.statvfs(self._folder), twice=twice)

    def check_room(self) -> None:
        """Look whether more is free than the reserve.

        Raises:
            NoRoomError: less is.
        """
        self._check_room(os.statvfs(self._folder))

    def _check_room(self, disk: os.statvfs_result, *, twice: bool = False) -> None:
        if not disk.f_blocks:
            return  # a file system that does not say how large it is
        reserve = min(self._reserve_bytes, RESERVED_SHARE * disk.f_blocks * disk.f_frsize)
        wanted = max(2 * reserve, LEAST_ROOM_BYTES) if twice else reserve
        free = disk.f_bavail * disk.f_frsize
        if free < wanted:
            raise NoRoomError(
                f"the disk is full but for {_in_words(free)}; {_in_words(reserve)} shall stay free"
            )

    def _what_happened(self, descriptor: int, named: os.stat_result | None) -> str:
        if self._is_detached():
            return "its disk was detached"
        if not self._folder.is_dir():
            return "its folder is gone"
        if not os.fstat(descriptor).st_nlink:
            return "the file was deleted"
        return "the file was moved" if named is None else "another file took its place"

    def _is_detached(self) -> bool:
        """Whether the folder was on a disk of its own, and its place is on the outer disk now."""
        return self._outer_device is not None and (_device(self._true_folder) == self._outer_device)


def _outer_device(folder: Path) -> int | None:
    """The device on which the folder's disk is mounted; None for the root's."""
    device = _device(folder)
    for outer in folder.parents:
        if _device(outer) != device:
            return _device(outer)
    return None


def _device(folder: Path) -> int | None:
    """The device of a folder, or of the first one above it that is there."""
    for place in (folder, *folder.parents):
        try:
            found = os.stat(place)
        except OSError:
            continue
        if stat.S_ISDIR(found.st_mode):
            return found.st_dev
    return None


def _in_words(size: float) -> str:
    return f"{size / (1 << 20):.1f} MiB"
