"""A real systemd beside the machine's own, booted in namespaces on a copy of the root.

It needs root, and a kernel with overlayfs and version 2 of cgroups. It has no network, clock or
kernel of its own; what would change these of the machine is masked. It ends with the context, and
leaves nothing behind.
"""

import contextlib
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

SYSTEMD = Path("/lib/systemd/systemd")
TARGET = """\
[Unit]
Description=what any service needs
Requires=basic.target
After=basic.target
"""
MASKED = (
    "avahi-daemon.socket",
    "proc-sys-fs-binfmt_misc.automount",
    "systemd-binfmt.service",
    "systemd-modules-load.service",
    "systemd-sysctl.service",
    "systemd-udevd.service",
)
"""What would change the machine's kernel, or speak to its network."""
BOOT = """
set -e
mount --make-rprivate /
mount -t tmpfs tmpfs "$1"
mkdir "$1/upper" "$1/work" "$1/root"
mount -t overlay overlay -o "lowerdir=/,upperdir=$1/upper,workdir=$1/work" "$1/root"
cd "$1/root"
mount -t proc proc proc
mount -t sysfs -o ro sysfs sys
mount -t tmpfs tmpfs sys/fs/cgroup
mount -t cgroup2 cgroup2 sys/fs/cgroup
mount --rbind /dev dev
mount -t tmpfs -o mode=755 tmpfs run
mount -t tmpfs -o mode=1777 tmpfs tmp
mkdir -p opt/python etc/reflexarc
mount --bind "$2" opt/python
systemd-id128 new > etc/machine-id
printf %s "$3" > etc/systemd/system/campaign.target
for unit in $4; do ln -sf /dev/null "etc/systemd/system/$unit"; done
pivot_root . mnt
umount -l /mnt
mount --make-rshared /
echo /opt/python/lib > etc/ld.so.conf.d/00-python.conf
ldconfig
exec env -i container=campaign PATH=/usr/sbin:/usr/bin:/sbin:/bin \\
    "$5" --unit=campaign.target --log-target=journal </dev/null >/dev/null 2>&1
"""
ROOMS = ("cli", "logs", "runtime")
"""What a robot's service loads."""
PATIENCE_S = 60.0


@dataclass
class BootedSystemd:
    """A context manager: inside, a systemd of its own runs.

    Args:
        folder: an empty one; the copy of the root is mounted there, in a namespace.
    """

    folder: Path
    pid: int = 0
    """Of it, as the machine counts."""
    cgroup: Path = field(init=False)
    """Its root among the groups of the machine."""
    _unshare: "subprocess.Popen[bytes] | None" = None

    def __enter__(self) -> Self:
        self.folder.mkdir(parents=True)
        self.cgroup = _cgroups() / f"campaign-{os.getpid()}-{id(self)}"
        self.cgroup.mkdir()
        joins = f'echo $$ > "{self.cgroup}/cgroup.procs"; exec "$@"'
        words = ["unshare", "--mount", "--pid", "--fork", "--uts", "--ipc", "--cgroup"]
        words += ["--kill-child", "sh", "-c", BOOT, "boot", str(self.folder), sys.base_prefix]
        words += [TARGET, " ".join(MASKED), str(SYSTEMD)]
        self._unshare = subprocess.Popen(["sh", "-c", joins, "joins", *words])
        self._wait_for_boot()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._unshare is not None:
            self._unshare.kill()  # and with it the first process of the namespace, so all of them
            self._unshare.wait()
        for group in sorted(self.cgroup.rglob("*/"), reverse=True):
            _remove_group(group)
        _remove_group(self.cgroup)

    def path(self, inside: str) -> Path:
        """Where one of its files is, as this process sees it."""
        return Path(f"/proc/{self.pid}/root") / inside.lstrip("/")

    def runs(self, *words: object) -> "subprocess.CompletedProcess[str]":
        """A command inside, to its end."""
        entered = ["nsenter", "-t", str(self.pid), "-m", "-p", "-u", "-i", "--wd=/", "--"]
        return subprocess.run(
            [*entered, *map(str, words)], capture_output=True, text=True, check=False
        )

    def make_environment(self) -> str:
        """Make an environment in which this process's modules are found; the path of its Python.

        Where a user that the service makes up can read it: no home is read there. They are compiled
        in the copy, as pip compiles what it installs.
        """
        self.runs("/opt/python/bin/python3", "-m", "venv", "--without-pip", "/opt/reflexarc")
        place = next(self.path("/opt/reflexarc/lib").glob("python*/site-packages"))
        site = [path for path in sys.path if path.endswith("site-packages")]
        ours = [path for path in sys.path if path and not path.startswith(sys.base_prefix)]
        lines = [f"import sys; sys.path[:0] = {[path for path in ours if path not in site]}"]
        lines += [f"import site; site.addsitedir({path!r})" for path in site]
        (place / "all.pth").write_text("\n".join(lines) + "\n")
        python = "/opt/reflexarc/bin/python"
        rooms = [path for path in ours if Path(path).name in ROOMS]
        self.runs(python, "-m", "compileall", "-q", *rooms)
        return python

    def _wait_for_boot(self) -> None:
        assert self._unshare is not None
        children = Path(f"/proc/{self._unshare.pid}/task/{self._unshare.pid}/children")
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s and self._unshare.poll() is None:
            with contextlib.suppress(OSError, ValueError, IndexError):
                self.pid = int(children.read_text().split()[0])
                if self.runs("systemctl", "is-active", "campaign.target").returncode == 0:
                    return
            time.sleep(0.1)
        raise RuntimeError("no systemd could be booted in namespaces: is this root, in a machine?")


def can_boot() -> bool:
    """Whether this machine lets us try."""
    tools = all(map(shutil.which, ("unshare", "nsenter", "systemctl")))
    if os.geteuid() != 0 or not SYSTEMD.exists() or not tools:
        return False
    mounts, kinds = Path("/proc/mounts").read_text(), Path("/proc/filesystems").read_text()
    if " cgroup2 " not in mounts or "overlay" not in kinds:
        return False
    tried = ["unshare", "--mount", "--pid", "--fork", "--uts", "--ipc", "--cgroup", "true"]
    return subprocess.run(tried, capture_output=True, check=False).returncode == 0


def _cgroups() -> Path:
    """Where version 2 of the control groups is mounted."""
    for line in Path("/proc/mounts").read_text().splitlines():
        _, place, kind, *_ = line.split()
        if kind == "cgroup2":
            return Path(place)
    raise RuntimeError("expected version 2 of control groups (cgroup2) to be mounted, found none")


def _remove_group(group: Path) -> None:
    """A group of processes that have ended; it is empty a moment later than they are."""
    end_s = time.monotonic() + PATIENCE_S
    while group.is_dir() and time.monotonic() < end_s:
        try:
            group.rmdir()
        except OSError:
            time.sleep(0.01)
