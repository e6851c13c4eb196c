"""Follows the rules of a systemd unit, as far as they say when a process is started and ended.

For machines on which no systemd runs. What it follows: Type=notify, WatchdogSec, TimeoutStartSec,
TimeoutStopSec, KillMode=mixed, Restart=on-failure, RestartSec, RestartSteps, RestartMaxDelaySec,
RestartPreventExitStatus, LoadCredential, and an ExecStartPost that resets the count of restarts.
Source: systemd.service(5), systemd.kill(5), systemd.exec(5), systemctl(1) and sd_notify(3), of
whose words it hears READY, WATCHDOG, STOPPING, STATUS and EXTEND_TIMEOUT_USEC. What a unit says of
rights it does not follow.
"""

import contextlib
import os
import shlex
import signal
import socket
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

from support.service_life import Life

LOOK_S = 0.005
CLEAN = (0, -signal.SIGHUP, -signal.SIGINT, -signal.SIGTERM, -signal.SIGPIPE)
"""How a service ends that has not failed: systemd.service(5), Restart=."""


def settings_of_unit(text: str) -> dict[str, str]:
    """The last value of each setting; of the command line, its words with `%%` and `$$` undone."""
    lines = (line.partition("=") for line in text.splitlines() if "=" in line and line[0] != "#")
    return {name: value for name, _, value in lines}


@dataclass
class FollowedLife(Life):
    """One process of the service, and what its manager knows of it."""

    process: "subprocess.Popen[bytes]" = field(kw_only=True)
    start_until_s: float = field(kw_only=True)
    """When its start has taken too long; later, if it asks for time."""
    fed_s: float = 0.0
    said: str = ""
    stopping_s: float | None = None
    """When it said that it ends."""
    asked_s: float | None = None
    """When it was asked to end."""


@dataclass
class Supervisor:
    """A context manager: inside, a thread keeps the service running."""

    unit: str
    folder: Path
    """Where it runs."""
    lives: list[FollowedLife] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._settings = settings_of_unit(self.unit)
        self._stopping = threading.Event()
        self._restarts = 0
        self._thread = threading.Thread(target=self._supervise, name="supervisor")

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stopping.set()
        self._thread.join()

    @property
    def gave_up(self) -> bool:
        """Whether it does not start the service again."""
        return not self._thread.is_alive()

    def _seconds(self, name: str) -> float:
        return float(self._settings[name])

    def _supervise(self) -> None:
        with tempfile.TemporaryDirectory() as place:
            while not self._stopping.is_set():
                life = self._live(Path(place) / f"notify{len(self.lives)}")
                if not self._starts_again(life):
                    return
                self._stopping.wait(self._pause_s(life))

    def _starts_again(self, life: FollowedLife) -> bool:
        """On failure: a time that ran out is one, whatever the status that came of it."""
        refused = self._settings.get("RestartPreventExitStatus", "").split()
        has_failed = life.status not in CLEAN or life.cause in ("start timeout", "watchdog")
        return has_failed and str(life.status) not in refused

    def _pause_s(self, life: FollowedLife) -> float:
        """From the first to the longest in equal ratios, by how often it was started again."""
        first_s = self._seconds("RestartSec")
        if life.ready_s is not None and "reset-failed" in self._settings.get("ExecStartPost", ""):
            self._restarts = 0
        self._restarts += 1
        if "RestartSteps" not in self._settings:
            return first_s
        done = min(1.0, (self._restarts - 1) / self._seconds("RestartSteps"))
        return float(first_s * (self._seconds("RestartMaxDelaySec") / first_s) ** done)

    def _live(self, place: Path) -> FollowedLife:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ours:
            ours.bind(str(place))
            ours.settimeout(LOOK_S)
            life = self._start(place)
            self.lives.append(life)
            while life.process.poll() is None:
                self._hear(life, ours)
                self._look(life, time.monotonic())
        life.ended_s, life.status = time.monotonic(), life.process.returncode
        with contextlib.suppress(ProcessLookupError):  # KillMode=mixed: the rest of them
            os.killpg(life.pid, signal.SIGKILL)
        return life

    def _start(self, place: Path) -> FollowedLife:
        credentials = place.with_name(f"{place.name}.credentials")
        line = self._settings["ExecStart"].replace("%%", "%").replace("$$", "$")
        words = shlex.split(line.replace("${CREDENTIALS_DIRECTORY}", str(credentials)))
        if "LoadCredential" in self._settings:
            name, _, path = self._settings["LoadCredential"].replace("%%", "%").partition(":")
            credentials.mkdir(mode=0o700)
            (credentials / name).write_bytes(Path(path).read_bytes())
        patience_us = round(self._seconds("WatchdogSec") * 1e6)
        environment = os.environ | {"NOTIFY_SOCKET": str(place), "WATCHDOG_USEC": str(patience_us)}
        with (self.folder / "said.txt").open("ab") as said:
            process = subprocess.Popen(
                words, cwd=self.folder, env=environment, stdout=said, stderr=said, process_group=0
            )
        now_s = time.monotonic()
        until_s = now_s + self._seconds("TimeoutStartSec")
        return FollowedLife(process.pid, now_s, process=process, start_until_s=until_s)

    def _hear(self, life: FollowedLife, ours: socket.socket) -> None:
        try:
            lines = ours.recv(8192).decode().split("\n")
        except TimeoutError:
            return
        now_s = time.monotonic()
        if "READY=1" in lines and life.ready_s is None:
            life.ready_s = life.fed_s = now_s
        if "WATCHDOG=1" in lines:
            life.fed_s = now_s
        for line in lines:
            if line.startswith("EXTEND_TIMEOUT_USEC="):
                extended_s = now_s + float(line.partition("=")[2]) / 1e6
                life.start_until_s = max(life.start_until_s, extended_s)
        if "STOPPING=1" in lines:
            life.stopping_s = now_s
        life.said = next((one for one in lines if one.startswith("STATUS=")), life.said)

    def _look(self, life: FollowedLife, now_s: float) -> None:
        if life.asked_s is not None:
            if now_s - life.asked_s > self._seconds("TimeoutStopSec"):
                life.process.kill()
            return
        if self._stopping.is_set():
            self._ask(life, signal.SIGTERM, "stop", now_s)
        elif life.ready_s is None:
            if now_s > life.start_until_s:
                self._ask(life, signal.SIGTERM, "start timeout", now_s)
        elif now_s - life.fed_s > self._seconds("WatchdogSec"):
            self._ask(life, signal.SIGABRT, "watchdog", now_s)

    def _ask(self, life: FollowedLife, number: signal.Signals, cause: str, now_s: float) -> None:
        """Send a signal, and SIGCONT behind it, as systemd does: also what is stopped shall end."""
        life.asked_s, life.cause = now_s, cause
        for each in (number, signal.SIGCONT):
            life.process.send_signal(each)
