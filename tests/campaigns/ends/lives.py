"""The processes of one robot: started one at a time on the whole machine, ended, and looked after.

Each has a process group of its own, so that a signal reaches it as one from a terminal does, and a
word in its environment by which all that it has left behind is found.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from support.ros2_drives import children, lives

READY_S = 60.0
END_S = 15.0
"""A process that was asked to end and has not by then is stuck."""
MARK = "REFLEXARC_ENDS"
TESTS = Path(__file__).parents[2]

starts: AbstractContextManager[object] = nullcontext()
"""Held while a process starts: one at a time disturbs the others less."""


class StuckError(Exception):
    """A process that does not do what it must."""


@dataclass
class Life:
    """One process, from its start to its end."""

    name: str
    process: "subprocess.Popen[bytes]"
    said: Path
    """What it wrote to standard error."""
    log: str = ""
    begun_ns: int = field(default_factory=time.time_ns)
    """When it was ready, on the wall clock."""

    @property
    def pid(self) -> int:
        return self.process.pid

    @property
    def is_over(self) -> bool:
        return self.process.poll() is not None

    def signal(self, number: int, *, to_group: bool = True) -> None:
        (os.killpg if to_group else os.kill)(self.pid, number)

    def ended(self) -> int:
        """Wait for its end; its exit status."""
        try:
            return self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.kill()
            raise StuckError(f"{self.name} has not ended after {END_S:g} s") from None

    def kill(self) -> None:
        """End it, whatever state it is in."""
        if not self.is_over:
            self.signal(signal.SIGKILL)
            self.process.wait()


def begin(name: str, words: list[object], ready: str, folder: Path, mark: str) -> Life:
    """Start a Python module, and wait until it says that it is ready."""
    number = len(list(folder.glob(f"{name}-*.err")))
    said = folder / f"{name}-{number}.err"
    # The commands are held up by nobody who does not read: both streams go to files.
    with starts, said.open("wb") as err, said.with_suffix(".out").open("wb") as out:
        process = subprocess.Popen(
            [sys.executable, "-m", *map(str, words)],
            stdout=out,
            stderr=err,
            cwd=folder,
            env={**os.environ, MARK: mark, "PYTHONPATH": _python_path()},
            process_group=0,
        )
        life = Life(name, process, said)
        wait_for(lambda: ready in said.read_text() or life.is_over, f"{name} is ready", READY_S)
    if life.is_over:
        raise StuckError(f"{name} ended at its start: {said.read_text()[-400:]}")
    life.begun_ns = time.time_ns()
    return life


def wait_for(holds: "object", what: str, patience_s: float) -> None:
    """Poll quickly until something holds."""
    assert callable(holds)
    end_s = time.monotonic() + patience_s
    while not holds():
        if time.monotonic() > end_s:
            raise StuckError(f"not within {patience_s:g} s: {what}")
        time.sleep(0.02)


def zombies(parents: list[int]) -> list[int]:
    """Ended children that these processes have not buried."""
    return [c for parent in parents for c in children(parent) if _exists(c) and not lives(c)]


def marked(mark: str) -> list[int]:
    """The processes that carry a mark in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
        except OSError:
            continue  # it has ended, or is somebody else's
    return found


def waited_ns(process_ids: Iterable[int]) -> int:
    """How long these processes have been ready to run while others ran, by the kernel's account.

    Of each process that thread counts which waited longest; the processes are added up, as one
    hands on to the next what it has done.
    """
    return sum(max(map(_waited_ns, _threads(pid)), default=0) for pid in process_ids)


def _threads(process_id: int) -> list[Path]:
    try:
        return list(Path(f"/proc/{process_id}/task").iterdir())
    except OSError:
        return []


def _waited_ns(thread: Path) -> int:
    try:  # running, waiting in the run queue, time slices: Documentation/scheduler/sched-stats.rst
        return int((thread / "schedstat").read_text().split()[1])
    except (OSError, IndexError):
        return 0


def _exists(process_id: int) -> bool:
    return Path(f"/proc/{process_id}").exists()


def _python_path() -> str:
    return os.pathsep.join(filter(None, (str(TESTS), os.environ.get("PYTHONPATH"))))
