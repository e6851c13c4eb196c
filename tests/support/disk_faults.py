"""Disks that fail under a recording: real mounts, for root in a mount namespace of its own.

Each fault strikes a small disk, a tmpfs or an ext4 on a loop device, while `run --record` writes
to it. Nothing here is simulated in the process that records.
"""

import os
import resource
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

SMALL, LARGE = 6, 40
"""Sizes of disks in MiB."""
SLOW_BYTES_PER_S = 2000
FILE_BYTES = 150_000
CGROUP = Path("/sys/fs/cgroup/blkio/reflexarc-disks")
WITHOUT_ROOT_S_PRIVILEGE = (
    "setpriv",
    "--bounding-set=-dac_override,-dac_read_search",
    "--inh-caps=-dac_override,-dac_read_search",
)
"""Root asks for no permission; without these capabilities it does."""


@dataclass
class Disk:
    """A mounted disk, and the log on it."""

    mount: Path
    device: str = ""
    image: Path | None = None
    log: Path = field(init=False)

    def __post_init__(self) -> None:
        self.log = self.mount / "runs" / "drive.mcap"
        self.log.parent.mkdir()

    @property
    def partial(self) -> Path:
        return self.log.with_name(self.log.name + ".partial")

    @property
    def filler(self) -> Path:
        return self.mount / "filler"


Strike = Callable[[Disk, int], None]
"""What happens to a disk, and the process that writes to it."""


@dataclass(frozen=True)
class DiskFault:
    """One kind."""

    name: str
    strike: Strike
    says: str
    """What the status has to say; empty: nothing is amiss."""
    exit_status: int = 1
    kind: str = "tmpfs"
    size_mib: int = LARGE
    flags: tuple[str, ...] = ()
    prefix: tuple[str, ...] = ()
    mend: Strike | None = None
    """Ends the fault; then a new part has to begin, if `resumes`."""
    resumes: bool = False
    limit_bytes: int | None = None
    """Of every file that the process writes."""
    keeps: bool = True
    """Whether anything of the first part can be left."""


@contextmanager
def mounted(kind: str, size_mib: int, folder: Path) -> Iterator[Disk]:
    """A disk of a kind; what is left mounted goes with the namespace."""
    mount, image = folder / "disk", folder / "backing" / "image"
    mount.mkdir()
    options = f"size={size_mib}m"
    if kind == "tmpfs":
        call("mount", "-t", "tmpfs", "-o", options, "none", mount)
        disk = Disk(mount)
    else:
        image.parent.mkdir()
        call("mount", "-t", "tmpfs", "-o", options, "none", image.parent)
        call("truncate", "-s", f"{size_mib - 2}M", image)
        call("mkfs.ext4", "-q", image)
        call("mount", "-o", "loop,errors=remount-ro", image, mount)
        found = subprocess.run(["losetup", "-j", image], capture_output=True, text=True, check=True)
        disk = Disk(mount, found.stdout.partition(":")[0], image)
    try:
        yield disk
    finally:
        for place in (mount, image.parent):
            subprocess.run(["umount", "-l", place], capture_output=True, check=False)


def call(*words: object) -> None:
    subprocess.run([*map(str, words)], check=True, capture_output=True)


def fill(disk: Disk, _: int) -> None:
    _fill(disk.filler)


def fill_almost(disk: Disk, _: int) -> None:
    """Less is free than the reserve, a tenth of a small disk, and more than nothing."""
    _fill(disk.filler, leave_bytes=SMALL << 16)


def _fill(path: Path, leave_bytes: int = 0) -> None:
    with suppress(OSError), path.open("wb", buffering=0) as file:
        while True:
            disk = os.fstatvfs(file.fileno())
            if leave_bytes and disk.f_bavail * disk.f_frsize <= leave_bytes:
                return
            file.write(bytes(4096))


def free(disk: Disk, _: int) -> None:
    disk.filler.unlink()


def take_inodes(disk: Disk, _: int) -> None:
    """A disk without inodes takes more of a file, and no new one."""
    call("mount", "-o", "remount,nr_inodes=20", disk.mount)
    with suppress(OSError):
        for number in range(40):
            (disk.mount / str(number)).touch()
    disk.partial.unlink()
    with suppress(OSError):
        (disk.mount / "one more").touch()


def remove_folder(disk: Disk, _: int) -> None:
    shutil.rmtree(disk.log.parent)


def rename_folder(disk: Disk, _: int) -> None:
    disk.log.parent.rename(disk.mount / "runs of before")


def make_read_only(disk: Disk, _: int) -> None:
    """What ext4 does by itself when it finds itself damaged."""
    Path(f"/sys/fs/ext4/{Path(disk.device).name}/trigger_fs_error").write_text("1")


def detach(disk: Disk, _: int) -> None:
    call("umount", "-l", disk.mount)


def attach(disk: Disk, _: int) -> None:
    if not disk.mount.is_mount():
        call("mount", "-o", "loop,errors=remount-ro", disk.image, disk.mount)


def delete(disk: Disk, _: int) -> None:
    disk.partial.unlink()


def slow_down(disk: Disk, pid: int) -> None:
    """The kernel writes so many bytes a second for this process and this disk."""
    CGROUP.mkdir(exist_ok=True)
    major_minor = Path(f"/sys/block/{Path(disk.device).name}/dev").read_text().strip()
    rate = f"{major_minor} {SLOW_BYTES_PER_S}"
    (CGROUP / "blkio.throttle.write_bps_device").write_text(rate)
    for task in Path(f"/proc/{pid}/task").iterdir():
        (CGROUP / "tasks").write_text(task.name)


def speed_up(disk: Disk, _: int) -> None:
    major_minor = Path(f"/sys/block/{Path(disk.device).name}/dev").read_text().strip()
    (CGROUP / "blkio.throttle.write_bps_device").write_text(f"{major_minor} 0")


def freeze(disk: Disk, _: int) -> None:
    call("fsfreeze", "-f", disk.mount)


def thaw(disk: Disk, _: int) -> None:
    call("fsfreeze", "-u", disk.mount)


def forbid(disk: Disk, _: int) -> None:
    disk.log.parent.chmod(0o555)


def take_the_name(disk: Disk, _: int) -> None:
    disk.log.write_bytes(b"somebody else's")


def starve_the_device(disk: Disk, _: int) -> None:
    """The device below the file system takes no more: writes succeed, a sync does not."""
    assert disk.image is not None
    _fill(disk.image.parent / "filler")


def reach_the_limit(disk: Disk, _: int) -> None:
    """Wait until the file is as large as the process may write."""
    while disk.partial.exists() and disk.partial.stat().st_size < FILE_BYTES:
        time.sleep(0.01)


def limited(limit_bytes: int | None) -> Callable[[], None] | None:
    """What a child does before it becomes the command."""
    if limit_bytes is None:
        return None
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))


NO_RESERVE = ("--reserve-mb", "0")
FAULTS: Sequence[DiskFault] = (
    DiskFault("full", fill, "No space left", size_mib=SMALL, flags=NO_RESERVE),
    DiskFault("full, reserve", fill_almost, "shall stay free", size_mib=SMALL),
    DiskFault(
        "freed again",
        fill,
        "No space left",
        size_mib=SMALL,
        flags=NO_RESERVE,
        mend=free,
        resumes=True,
    ),
    DiskFault("folder gone", remove_folder, "folder is gone", resumes=True, keeps=False),
    DiskFault("folder renamed", rename_folder, "folder is gone", resumes=True),
    DiskFault("read-only", make_read_only, "Read-only", kind="ext4"),
    DiskFault("detached", detach, "detached", kind="ext4", mend=attach, resumes=True),
    DiskFault("deleted", delete, "deleted", resumes=True, keeps=False),
    DiskFault("no inodes", take_inodes, "deleted", keeps=False),
    DiskFault("ulimit -f", reach_the_limit, "File too large", limit_bytes=FILE_BYTES, resumes=True),
    DiskFault("slow", slow_down, "slow", exit_status=0, kind="ext4", mend=speed_up),
    DiskFault("hangs", freeze, "slow", exit_status=0, kind="ext4", mend=thaw),
    DiskFault("permission taken", forbid, "cannot be written", prefix=WITHOUT_ROOT_S_PRIVILEGE),
    DiskFault("name appears", take_the_name, "got the name"),
    DiskFault("sync fails", starve_the_device, "rror", kind="ext4", flags=NO_RESERVE),
)
