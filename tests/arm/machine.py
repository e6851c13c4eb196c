"""An Arm computer in a folder: an emulator, Debian's Python for arm64, and wheels for aarch64.

qemu-user emulates one Linux process at a time, not a whole computer. Nothing is installed on this
machine and nothing needs root: apt and pip, as they are configured here, download packages into
the folder, and they are unpacked there. A second call downloads
nothing unless the pinned versions, or this module, have changed.
"""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.errors import ReflexarcError

ROOT = Path(__file__).parents[2]
ROOMS = ("cli", "runtime", "logs", "sim_bridge", "trainer", "pictures")
PINS = ROOT / "constraints.txt"
EMULATORS = ("qemu-aarch64-static", "qemu-aarch64")
GLIBC_MINORS = range(17, 37)
"""Wheels for glibc 2.17 to 2.36, the one of Debian 12."""
CPUINFO = """\
processor\t: {number}
Features\t: fp asimd evtstrm aes pmull sha1 sha2 crc32 cpuid
CPU implementer\t: 0x41
CPU architecture: 8
CPU variant\t: 0x0
CPU part\t: 0xd08
CPU revision\t: 3

"""
"""What a Cortex-A72 says in /proc/cpuinfo. Without it an emulated process reads that of the x86
processor below, and onnxruntime, which finds no Arm processor there, crashes as it is imported."""


@dataclass(frozen=True)
class ArmMachine:
    """Runs Python programs as an aarch64 Linux would, one process at a time."""

    emulator: Path
    root: Path
    packages: Path
    cache: Path

    def run_python(self, arguments: Sequence[str], cpu: str) -> None:
        """Run a program of this repository, in its folder, on one of qemu's models of a processor.

        Raises:
            ReflexarcError: it ended otherwise than with 0.
        """
        command = [str(self._python(cpu)), *arguments]
        status = subprocess.run(command, cwd=ROOT, env=self._environment(), check=False).returncode
        if status:
            raise ReflexarcError(f"emulated Python on {cpu}: ended with status {status}")

    def _python(self, cpu: str) -> Path:
        """A script that starts Python on a model of a processor, for us and for Python itself.

        What Python takes for its own name (`sys.executable`) is that of the script: the kernel,
        which is not told of qemu, can start no Arm program. It lies beside Python, which looks for
        its library from there.
        """
        binaries = self.root / "usr" / "bin"
        script = binaries / f"python-on-{cpu}"
        words = (self.emulator, "-L", self.root, "-cpu", cpu, "-0", script, binaries / "python3")
        script.write_text(f'#!/bin/sh\nexec {shlex.join(map(str, words))} "$@"\n')
        script.chmod(0o755)
        return script

    def _environment(self) -> dict[str, str]:
        """Nothing of this machine's own: settings for BLAS may name kernels of its processor."""
        paths = [self.packages, *(ROOT / room for room in ROOMS)]
        return {
            "LANG": "C.UTF-8",
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONPATH": os.pathsep.join(map(str, paths)),
            "PYTHONPYCACHEPREFIX": str(self.cache),
        }


def build_machine(folder: Path) -> ArmMachine:
    """Make the machine in a folder, or take the one that stands there.

    Raises:
        ReflexarcError: a tool, a package or the network is missing.
    """
    if platform.machine() == "aarch64":
        raise ReflexarcError("this machine is an Arm computer itself: pytest tests/golden says it")
    stamp, recipe = folder / "made-from.txt", _recipe()
    if not stamp.exists() or stamp.read_text(encoding="utf-8") != recipe:
        print(f"test-arm: making the machine in {folder.name}/ …", file=sys.stderr)
        _fill(folder)
        stamp.write_text(recipe, encoding="utf-8")
    return ArmMachine(
        emulator=_emulator(folder),
        root=folder / "root",
        packages=folder / "packages",
        cache=folder / "pycache",
    )


def _recipe() -> str:
    """All that decides what is in the folder."""
    return "\n".join([*_requirements(), PINS.read_text(), Path(__file__).read_text()])


def _requirements() -> list[str]:
    """What a robot needs, out of pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return list(project["dependencies"])


def _fill(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    if not _installed_emulator():
        _unpack_debian(folder, "emulator", ["qemu-user-static"])
        _keep_only_arm(folder / "emulator" / "usr" / "bin")
    _unpack_debian(folder, "root", ["python3", "libstdc++6"], architecture="arm64")
    _complete_root(folder / "root")
    _install_wheels(folder)
    shutil.rmtree(folder / "apt")  # what it downloaded is unpacked


def _keep_only_arm(binaries: Path) -> None:
    """Remove the emulators of thirty other processors, a third of a gigabyte."""
    for file in binaries.iterdir():
        if file.name not in EMULATORS:
            file.unlink()


def _installed_emulator() -> Path | None:
    found = [shutil.which(name) for name in EMULATORS]
    return next((Path(path) for path in found if path), None)


def _emulator(folder: Path) -> Path:
    unpacked = [folder / "emulator" / "usr" / "bin" / name for name in EMULATORS]
    found = _installed_emulator() or next((path for path in unpacked if path.exists()), None)
    if found is None:
        raise ReflexarcError("qemu-aarch64: not found; apt-get install qemu-user-static")
    return found


def _unpack_debian(folder: Path, name: str, packages: list[str], architecture: str = "") -> None:
    """Unpack Debian packages, with all that they depend on, into a folder of that name.

    apt gets lists, a cache and an empty list of installed packages of its own, so that it knows of
    nothing on this machine and changes nothing.
    """
    apt = folder / "apt" / name
    for part in ("state/lists/partial", "cache/archives/partial"):
        (apt / part).mkdir(parents=True)
    (apt / "status").touch()
    options = {
        "Dir::State": f"{apt}/state",
        "Dir::State::status": f"{apt}/status",
        "Dir::Cache": f"{apt}/cache",
        "APT::Sandbox::User": "root",  # the folder need not be readable for apt's own user
        "APT::Update::Error-Mode": "any",  # a network that is missing is an error at once
    }
    if architecture:
        options |= {"APT::Architecture": architecture, "APT::Architectures": architecture}
    apt_get = ["apt-get", "-qq", *(f"-o{key}={value}" for key, value in options.items())]
    _call([*apt_get, "update"])
    _call([*apt_get, "install", "--download-only", "--no-install-recommends", "-y", *packages])
    for archive in sorted((apt / "cache" / "archives").glob("*.deb")):
        _call(["dpkg-deb", "--extract", str(archive), str(folder / name)])


def _complete_root(root: Path) -> None:
    if not (root / "lib").exists():  # from Debian 13 on: that link is made by what is left out
        (root / "lib").symlink_to("usr/lib")
    (root / "proc").mkdir(exist_ok=True)
    entries = [CPUINFO.format(number=number) for number in range(os.cpu_count() or 1)]
    (root / "proc" / "cpuinfo").write_text("".join(entries), encoding="utf-8")


def _install_wheels(folder: Path) -> None:
    version = (folder / "root" / "usr" / "bin" / "python3").readlink().name.removeprefix("python")
    platforms = [f"manylinux_2_{minor}_aarch64" for minor in reversed(GLIBC_MINORS)]
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _call(
        [
            *pip,
            *("--no-compile", "--only-binary=:all:", f"--python-version={version}"),
            *(f"--platform={name}" for name in [*platforms, "manylinux2014_aarch64"]),
            f"--constraint={PINS}",
            f"--target={folder / 'packages'}",
            *_requirements(),
        ]
    )


def _call(command: list[str]) -> None:
    """Run a tool quietly; what it complains of last becomes the error."""
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except FileNotFoundError:
        raise ReflexarcError(
            f"{command[0]}: not found; install apt and dpkg (Debian, or a system made of it)"
        ) from None
    except subprocess.CalledProcessError as error:
        said = [line for line in error.stderr.splitlines() if line.startswith(("E:", "ERROR:"))]
        tool = Path(command[0]).name if command[0] != sys.executable else "pip"
        raise ReflexarcError(
            f"{tool}: {said[0] if said else f'status {error.returncode}'} (needed are a network, "
            "Debian's packages for this machine and for arm64, and PyPI's wheels for aarch64)"
        ) from None
