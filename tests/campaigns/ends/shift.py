"""A shift: one robot that drives, and comes to one end after the other."""

import math
import os
import random
import signal
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from campaigns.ends.crew import Crew, Robot
from campaigns.ends.judge import Outcome
from campaigns.ends.kinds import ASKED, FAULTS, KINDS, Kind
from campaigns.ends.lives import StuckError, waited_ns
from campaigns.ends.on_bus import bus_robot
from campaigns.ends.on_ros2 import ros_robot
from support.ros2_drives import lives as is_alive
from support.ros2_robot import free_port

STANDS_S = 0.6
"""Who has been told to stand stands after so long."""
NEVER_S = 3.0
"""Who has not been told to stand by then never is."""
AGAIN_S = 0.8
"""A robot whose process goes on by itself is watched for so long."""
CREW = ("runtime", "body", "bridge", "scanner")
TRACES = ("Traceback", "panicked")


@dataclass(frozen=True)
class Shift:
    """What one robot shall go through."""

    robot: int
    place: str
    backend: str
    ends: tuple[tuple[int, int], ...]
    """(its kind's number in `KINDS`, the seed of its moment)."""
    policy: Path
    folder: Path


@dataclass
class Report:
    """What came of a shift."""

    outcomes: list[Outcome] = field(default_factory=list)
    logs: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)


def work(shift: Shift) -> Report:
    """Go through all ends; a robot that is stuck is replaced by another one."""
    report, left = Report(), list(shift.ends)
    while left:
        folder = shift.folder / f"{shift.robot}-{len(shift.ends) - len(left)}"
        folder.mkdir(parents=True)
        begun = len(left)
        try:
            _work(shift, folder, left, report)
        except Exception as error:  # one broken robot must not end the campaign
            report.failures.append(f"robot {shift.robot}: {error!r}"[:600])
            if len(left) == begun:
                left.pop(0)
    return report


def _work(shift: Shift, folder: Path, left: list[tuple[int, int]], report: Report) -> None:
    with _robot(shift, folder) as robot:
        crew = Crew(robot, folder, uuid.uuid4().hex)
        try:
            with crew:
                crew.complete()
                while left:
                    number, seed = left.pop(0)
                    outcome = Outcome(KINDS[number].name, KINDS[number].bound_ms, shift.robot)
                    report.outcomes.append(outcome)
                    come_to(robot, crew, KINDS[number], random.Random(seed), outcome)
                    if outcome.failures:
                        return  # with another robot
        finally:
            report.logs += crew.logs
            report.failures += crew.failures


@contextmanager
def _robot(shift: Shift, folder: Path) -> Iterator[Robot]:
    port = free_port()
    if shift.place == "bus":
        with bus_robot(shift.policy, port, shift.backend, folder) as on_bus:
            yield on_bus
    else:
        with ros_robot(shift.policy, port, shift.backend) as on_ros2:
            yield on_ros2


def come_to(robot: Robot, crew: Crew, kind: Kind, chance: random.Random, outcome: Outcome) -> None:
    """Bring a robot that drives to one end, measure, and let it drive again."""
    time.sleep(chance.uniform(0.0, 0.1))
    companion = crew.companion
    lasts_s = chance.uniform(*kind.blow.lasts_s)
    if kind.victim in CREW:
        outcome.lived_ms = (time.time_ns() - crew[kind.victim].begun_ns) * 1e-6
    patience = Patience(robot, crew, kind)
    outcome.ended_ns = time.time_ns()
    try:
        strike(crew, kind, companion)
        outcome.waited_ms = patience.until_told(outcome.ended_ns, lasts_s)
        if not (kind.is_quick or kind.drives_on):  # who was told late stands late
            lasts_s = max(lasts_s, (time.time_ns() - outcome.ended_ns) * 1e-9 + STANDS_S)
        _watch(robot, crew, kind, lasts_s, outcome)
        _settle(crew, kind, companion, outcome)
        crew.complete()
        crew.check()
    except StuckError as error:
        outcome.failures.append(str(error))


class Patience:
    """Looks until the robot was told to stand, and says how long its processes had to wait for a
    core until then.

    Args:
        robot: which.
        crew: of it.
        kind: what happens to it.
    """

    def __init__(self, robot: Robot, crew: Crew, kind: Kind) -> None:
        self._robot, self._kind = robot, kind
        self._pids = crew.pids
        self._before = {pid: waited_ns([pid]) for pid in self._pids}

    def until_told(self, since_ns: int, lasts_s: float) -> float:
        """Milliseconds of waiting from the end to that word, if it comes."""
        if self._kind.bound_ms is None:
            return 0.0
        time.sleep(min(lasts_s, self._kind.bound_ms * 1e-3))
        lasts_s = lasts_s if self._kind.is_quick else max(lasts_s, NEVER_S)
        waited_ms = self._waited_ms()
        while (now_ns := time.time_ns()) < since_ns + lasts_s * 1e9:
            if self._robot.motion(self._kind, since_ns, now_ns).told_ms < math.inf:
                break
            time.sleep(0.01)
            waited_ms = self._waited_ms()
        return waited_ms

    def _waited_ms(self) -> float:
        now = {pid: waited_ns([pid]) for pid in self._pids}
        return sum(max(0, now[pid] - before) for pid, before in self._before.items()) * 1e-6


def strike(crew: Crew, kind: Kind, companion: int) -> None:
    """Do it."""
    if "companion" in kind.victim:
        os.kill(companion, kind.blow.number)
    if kind.victim != "companion":
        name = kind.victim.split()[0]
        crew[name].signal(kind.blow.number, to_group=kind.blow.number not in FAULTS)


def _watch(robot: Robot, crew: Crew, kind: Kind, lasts_s: float, outcome: Outcome) -> None:
    """Wait for as long as it lasts; note what the robot did meanwhile."""
    time.sleep(max(0.0, lasts_s - (time.time_ns() - outcome.ended_ns) * 1e-9))
    if kind.drives_on and not robot.drives():
        outcome.failures.append("it did not drive on")
    until_ns = time.time_ns()
    if kind.blow.resumes == "asked":
        _resume(crew, kind)
    if kind.is_quick:
        time.sleep(max(0.0, AGAIN_S - lasts_s))
        until_ns = time.time_ns()
    motion = robot.motion(kind, outcome.ended_ns, until_ns)
    outcome.told_ms = None if kind.drives_on else motion.told_ms
    outcome.stand_ms, outcome.rolled_mm = motion.stand_ms, motion.rolled_mm


def _resume(crew: Crew, kind: Kind) -> None:
    if kind.victim == "companion":
        os.kill(crew.companion, signal.SIGCONT)
    else:
        crew[kind.victim].signal(signal.SIGCONT)


def _settle(crew: Crew, kind: Kind, companion: int, outcome: Outcome) -> None:
    """Wait for the ends of all that must end, and see whether they ended as they should."""
    if kind.victim == "companion":
        if kind.blow.resumes == "never":  # a bridge is started together with its companion
            _expect(crew, "bridge", ASKED[1].number, (0,), outcome)
        return
    name = kind.victim.split()[0]
    hangs = kind.blow.name.startswith("hangs") and name != "runtime"
    if None not in kind.blow.statuses:
        _expect(crew, name, signal.SIGKILL if hangs else 0, kind.blow.statuses, outcome)
    elif crew[name].is_over and crew[name].process.returncode not in kind.blow.statuses:
        outcome.failures.append(f"{name} ended with {crew[name].process.returncode}")
    if name == "runtime" and crew[name].is_over:
        outcome.log = crew[name].log
    if name == "bridge" and crew[name].is_over and companion and is_alive(companion):
        crew.gone(companion)


def _expect(
    crew: Crew, name: str, number: int, statuses: tuple[int | None, ...], outcome: Outcome
) -> None:
    """Send a process a signal, if any, and see how it ends."""
    life = crew[name]
    if number:
        life.signal(number)
    status = life.ended()
    said = life.said.read_text(errors="replace")
    if status not in statuses or any(trace in said for trace in TRACES):
        outcome.failures.append(f"{name} ended with {status}: {said[-400:]}")
