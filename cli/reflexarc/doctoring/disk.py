"""The disk of the records: room, kind, and how long it takes to keep something for good."""

import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.machine_files import text_of
from reflexarc_runtime.errors import first_line

WRITTEN_BYTES = 1 << 22
SYNCS = 8
LEAST_FREE_MB = 1000.0
LEAST_MB_S = 5.0
SLOW_SYNC_S = 0.5
_NETWORK = ("nfs", "nfs4", "cifs", "smb3", "9p", "fuse.sshfs", "ceph")
_IN_MEMORY = ("tmpfs", "ramfs")


def check_disk(folder: Path) -> Iterator[CheckRow]:
    """All that is said of the folder's disk; what is written has no name, and is gone."""
    try:
        room = os.statvfs(folder)
    except OSError as error:
        yield CheckRow("disk", Health.BAD, f"{folder}: {first_line(error)}", "nothing is recorded")
        return
    yield judge_room(room.f_bavail * room.f_frsize / 1e6)
    yield judge_kind(kind_of(folder.resolve(), text_of("/proc/self/mounts") or ""))
    try:
        yield judge_speed(*_measure(folder))
    except OSError as error:
        yield CheckRow(
            "disk speed",
            Health.BAD,
            f"{folder}: {first_line(error)}",
            "nothing can be recorded there",
            "another folder, or the right to write",
        )


def judge_room(free_mb: float) -> CheckRow:
    """How much is free."""
    found = f"{free_mb / 1e3:.1f} GB free"
    if free_mb >= LEAST_FREE_MB:
        return well("disk room", found)
    why = "recording stops, or drops its oldest parts, when it is full"
    return CheckRow("disk room", Health.MIND, found, why, "--keep-mb, or more room")


def judge_kind(kind: str | None) -> CheckRow:
    """Which file system."""
    if kind is None:
        return unknown("file system", "/proc/self/mounts does not tell")
    if kind in _NETWORK:
        why = "a network that stands still holds up the recording, and loses it"
        return CheckRow("file system", Health.MIND, kind, why, "a disk of this machine")
    if kind in _IN_MEMORY:
        why = "it is memory: the log is gone after a power failure, and takes the loop's room"
        return CheckRow("file system", Health.MIND, kind, why, "a disk of this machine")
    return well("file system", kind)


def judge_speed(mb_s: float, sync_s: float) -> CheckRow:
    """How quickly it keeps what is written."""
    found = f"{mb_s:.0f} MB/s, a sync takes up to {1e3 * sync_s:.1f} ms"
    if mb_s >= LEAST_MB_S and sync_s <= SLOW_SYNC_S:
        return well("disk speed", found)
    why = "the recorder falls behind, in its own thread; what its queue cannot hold is lost"
    return CheckRow("disk speed", Health.MIND, found, why, "another disk")


def kind_of(folder: Path, mounts: str) -> str | None:
    """The file system of a folder, by the longest mount point above it."""
    found, longest = None, -1
    for line in mounts.splitlines():
        words = line.split()
        if len(words) < 3:
            continue
        point = Path(words[1].replace("\\040", " "))
        if folder.is_relative_to(point) and len(point.parts) >= longest:
            found, longest = words[2], len(point.parts)
    return found


def _measure(folder: Path) -> tuple[float, float]:
    """Megabytes a second with a sync, and the longest of some small syncs, s."""
    with tempfile.TemporaryFile(dir=folder) as file:
        began_s = time.perf_counter()
        file.write(os.urandom(WRITTEN_BYTES))
        file.flush()
        os.fsync(file.fileno())
        mb_s = WRITTEN_BYTES / 1e6 / (time.perf_counter() - began_s)
        longest_s = 0.0
        for _ in range(SYNCS):
            began_s = time.perf_counter()
            file.write(bytes(4096))
            file.flush()
            os.fsync(file.fileno())
            longest_s = max(longest_s, time.perf_counter() - began_s)
    return mb_s, longest_s
