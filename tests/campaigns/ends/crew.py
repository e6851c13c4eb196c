"""The crew of one robot: the processes that drive it, of which some end and are started again."""

import os
import signal
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from campaigns.ends import lives
from campaigns.ends.kinds import Kind
from campaigns.ends.lives import Life, StuckError, wait_for
from support.ros2_drives import children
from support.ros2_drives import lives as is_alive

DRIVES_S = 30.0
"""A robot whose processes are all there drives within this time, or something is stuck."""
GONE_S = 8.0
"""A companion speaks for 2 s after its bridge has gone; then it closes its session."""
MAIN = "campaigns.ends.faulty"


@dataclass(frozen=True)
class Member:
    """How to start one process of a crew."""

    words: Callable[[], list[object]]
    ready: str
    """What it says when it is."""


@dataclass(frozen=True)
class Motion:
    """What became of a robot after an end."""

    told_ms: float
    """Until it was told to stand; infinite: never."""
    stand_ms: dict[str, float] = field(default_factory=dict)
    """Until it stood, by base."""
    rolled_mm: dict[str, float] = field(default_factory=dict)


class Robot(Protocol):
    """A robot whose processes can be ended, and who hears what it is told."""

    @property
    def members(self) -> dict[str, Member]:
        """The processes that it needs, in the order of their start."""
        ...

    def drives(self) -> bool:
        """Whether it has been driving for a while, and still does."""
        ...

    def motion(self, kind: Kind, since_ns: int, until_ns: int) -> Motion:
        """What it did between two moments of the wall clock."""
        ...


class Crew:
    """Keeps the processes of a robot. A context manager: at its end all of them are asked to end.

    Args:
        robot: theirs.
        folder: for what they say, and for the logs of its runtimes.
        mark: by which all that they leave behind is found.
    """

    def __init__(self, robot: Robot, folder: Path, mark: str) -> None:
        self._robot, self._folder, self._mark = robot, folder, mark
        self._lives: dict[str, Life] = {}
        self.logs: list[str] = []
        self.failures: list[str] = []
        """What went wrong at the end of all."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self._dismiss()
        finally:
            for life in self._lives.values():
                life.kill()

    def __getitem__(self, name: str) -> Life:
        return self._lives[name]

    @property
    def companion(self) -> int:
        """The number of the companion's process; 0: there is none."""
        bridge = self._lives.get("bridge")
        return next(iter(children(bridge.pid)), 0) if bridge else 0

    @property
    def pids(self) -> list[int]:
        """All of its living processes, and this one, which listens."""
        living = [life.pid for life in self._lives.values() if not life.is_over]
        return [*living, *filter(None, [self.companion]), os.getpid()]

    def complete(self) -> None:
        """Start whoever is missing, and wait until the robot drives."""
        for name, member in self._robot.members.items():
            if name not in self._lives or self._lives[name].is_over:
                self._lives[name] = self._begun(name, member)
        wait_for(self._robot.drives, "the robot drives", DRIVES_S)

    def check(self) -> None:
        """Whether everybody who shall live does, and nobody is left unburied.

        Raises:
            StuckError: not so.
        """
        over = [life.name for life in self._lives.values() if life.is_over]
        if over:
            raise StuckError(f"ended unasked: {', '.join(over)}")
        pids = [life.pid for life in self._lives.values()]
        wait_for(lambda: not lives.zombies(pids), "no zombie is left", GONE_S)

    def gone(self, process_id: int) -> None:
        """Wait until a companion has gone by itself."""
        wait_for(lambda: not is_alive(process_id), "the companion has ended", GONE_S)

    def _begun(self, name: str, member: Member) -> Life:
        words = member.words()
        log = ""
        if name == "runtime":
            log = str(self._folder / f"run-{len(self.logs)}.mcap")
            words = [*words, "--record", log]
            self.logs.append(log)
        life = lives.begin(name, words, member.ready, self._folder, self._mark)
        life.log = log
        return life

    def _dismiss(self) -> None:
        """Ask everybody to end, the runtime first; nobody may stay."""
        for name in reversed(list(self._lives)):
            life = self._lives[name]
            life.signal(signal.SIGTERM)
            status = life.ended()
            if name != "scanner" and status != 0:
                self.failures.append(f"{name} ended with {status}: {life.said.read_text()[-300:]}")
        try:
            wait_for(lambda: not lives.marked(self._mark), "nobody is left behind", GONE_S)
        except StuckError as error:
            self.failures.append(f"{error}: {lives.marked(self._mark)}")
