"""A service under a real systemd, told as lives."""

import shutil
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

from campaigns.deaths.booted import BootedSystemd
from support.service_life import Life

LOOK_S = 0.005
ASK_S = 0.05
SHOWN = (
    "MainPID,ActiveState,Result,ExecMainCode,ExecMainStatus,"
    "ExecMainStartTimestampMonotonic,ActiveEnterTimestampMonotonic,ExecMainExitTimestampMonotonic"
)
EXITED = 1
"""`ExecMainCode` of a process that was not ended by a signal: CLD_EXITED, sigaction(2)."""


@dataclass
class SystemdService:
    """A context manager: inside, systemd keeps the service running, and a thread takes note.

    The processes are looked at by the machine's own count, which costs little; systemd is asked
    when they change. The times are systemd's.
    """

    system: BootedSystemd
    name: str
    logs: str
    """Where they are inside."""
    kept: Path
    """Where they are copied at the end."""
    lives: list[Life] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="systemd's service")

    def __enter__(self) -> Self:
        self.system.runs("systemctl", "daemon-reload")
        started = self.system.runs("systemctl", "start", "--no-block", self.name)
        assert started.returncode == 0, started.stderr
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.system.runs("systemctl", "stop", self.name)
        self._stopping.set()
        self._thread.join()
        if self.lives:
            self._end(self.lives[-1], self._shown(), "stop")
        shutil.copytree(self.system.path(self.logs.replace("/lib/", "/lib/private/", 1)), self.kept)

    @property
    def gave_up(self) -> bool:
        """Whether systemd does not start the service again."""
        return not self._thread.is_alive()

    def _watch(self) -> None:
        while not self._stopping.wait(LOOK_S):
            life = self.lives[-1] if self.lives else None
            if life is None or life.ended_s is not None:
                self._begin()
            elif not self._is_there(life):
                shown = self._shown()
                cause = "watchdog" if shown["Result"] == "watchdog" else ""
                self._end(life, shown, cause)
                if shown["ActiveState"] in ("inactive", "failed"):
                    return
            elif life.ready_s is None:
                self._look(life)

    def _begin(self) -> None:
        """Take note of another life, if one has begun."""
        for pid in self._children():
            if not any(life.pid == pid for life in self.lives):
                self.lives.append(Life(pid, time.monotonic()))

    def _look(self, life: Life) -> None:
        shown = self._shown()
        began_s = _seconds(shown, "ExecMainStart")
        ready_s = _seconds(shown, "ActiveEnter")
        if shown["ActiveState"] == "active" and ready_s > began_s and self._is_there(life):
            life.began_s, life.ready_s = began_s, ready_s
        else:
            self._stopping.wait(ASK_S)

    def _end(self, life: Life, shown: Mapping[str, str], cause: str) -> None:
        """Take note of an end; of how, unless the next one has begun before systemd could say."""
        ended_s = _seconds(shown, "ExecMainExit")
        if ended_s <= life.began_s:
            life.ended_s = time.monotonic()
            return
        status = int(shown["ExecMainStatus"])
        life.status = status if int(shown["ExecMainCode"]) == EXITED else -status
        life.ended_s, life.cause = ended_s, cause

    def _children(self) -> list[int]:
        """The processes of the service that systemd itself started."""
        group = self.system.cgroup / "system.slice" / self.name / "cgroup.procs"
        found: list[int] = []
        with suppress(OSError):
            found = [int(line) for line in group.read_text().split()]
        return [pid for pid in found if _parent(pid) == self.system.pid]

    def _is_there(self, life: Life) -> bool:
        return _parent(life.pid) == self.system.pid and _state(life.pid) != "Z"

    def _shown(self) -> Mapping[str, str]:
        done = self.system.runs("systemctl", "show", self.name, "-p", SHOWN)
        lines = (line.partition("=") for line in done.stdout.splitlines())
        return {name: value for name, _, value in lines}


def _seconds(shown: Mapping[str, str], name: str) -> float:
    return int(shown[f"{name}TimestampMonotonic"]) * 1e-6


def _stat(pid: int) -> list[str]:
    """State and parent of a process; of none, nothing."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return ["", "0"]


def _parent(pid: int) -> int:
    return int(_stat(pid)[1])


def _state(pid: int) -> str:
    return _stat(pid)[0]
