"""A robot that drives by `reflexarc ros2` and `reflexarc run`, until something ends one of them."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from support.processes import Process, started, wait_until
from support.ros2_robot import Robot, Told, robot

FAST_ENOUGH = ("--max-linear", 2, "--max-lateral", 2, "--max-angular", 2)
"""Limits that no action of the reference contract exceeds."""
STEADY = 25
"""So many commands of one kind in a row are no accident."""


@dataclass(frozen=True)
class Drive:
    """A robot that drives, and the process between it and the runtime."""

    body: Robot
    bridge: Process
    port: int

    @property
    def companion(self) -> int:
        """Number of the companion's process; 0: there is none."""
        return next(iter(children(self.bridge.pid)), 0)


@contextmanager
def driving(policy: Path, port: int, *flags: object) -> Iterator[Drive]:
    """A robot that drives; everything ends with the context."""
    with (
        robot(port, "scan", "cmd_vel", stamped=False) as body,
        started("run", policy, "--input", "scan", "--port", port),
        bridged(body, port, *(flags or (*FAST_ENOUGH, "--auto-arm"))) as drive,
    ):
        yield drive


@contextmanager
def bridged(body: Robot, port: int, *flags: object) -> Iterator[Drive]:
    """The same for a robot and a runtime that are there already."""
    words = ("ros2", "--json", "--port", port, *flags)
    with (
        TemporaryDirectory() as folder,
        started(*words, cwd=Path(folder), own_group=True) as bridge,
    ):
        begun = len(body.told)
        wait_until(lambda: moves(body.told[begun:]), "the robot drives")
        try:
            yield Drive(body, bridge, port)
        finally:
            if bridge.poll() is None:
                bridge.send_signal(signal.SIGCONT)  # a stopped process hears nothing else


def moves(told: list[Told]) -> bool:
    """Whether the robot has been told to move for a while."""
    return len(told) >= STEADY and not any(word.is_standstill for word in told[-STEADY:])


def stands(told: list[Told]) -> bool:
    """Whether it has been told to stand for a while."""
    return len(told) >= STEADY and all(word.is_standstill for word in told[-STEADY:])


def silence_s(told: list[Told]) -> float:
    """How long nobody has told it anything."""
    return (time.time_ns() - told[-1].arrived_ns) * 1e-9


def children(process_id: int) -> list[int]:
    """The child processes of a process."""
    try:
        words = Path(f"/proc/{process_id}/task/{process_id}/children").read_text()
    except OSError:
        return []
    return [int(word) for word in words.split()]


def lives(process_id: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        state = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state not in "ZX"


def kill_group(process: Process, number: signal.Signals) -> int:
    """Send a signal to the process and all of its group; the time just before, wall clock, ns."""
    now_ns = time.time_ns()
    os.killpg(process.pid, number)
    return now_ns
