"""The list of runs in their order, each done by a process of its own, and none done twice.

A run is one file with one line of JSON, `NAME-SEED.json` or `NAME-SEED-cold.json`. It is written
when the run is over, and at once: an existing file is whole.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from learning_race.contenders import COLD, Contender
from learning_race.record import read_record
from reflexarc_runtime.files import write_atomically

PROGRAM = Path(__file__).parents[1] / "learning.py"
OVERHEAD_S = 15.0
"""Approximate time of a run besides its limit: start, warm-up, looks, test worlds."""
COLD_S = 60.0
"""Approximate time of a cold run."""


@dataclass(frozen=True)
class Scale:
    """Time limit of the runs, and size of the measurement on test worlds."""

    budget_s: float = 60.0
    test_agents: int = 4096
    test_steps: int = 2000

    def limited(self, contender: Contender) -> Contender:
        """The contender, with at most this time limit."""
        return replace(contender, budget_s=min(contender.budget_s, self.budget_s))

    @property
    def arguments(self) -> list[str]:
        """Arguments for the command of a run."""
        numbers = {"--budget-s": self.budget_s, "--test-agents": self.test_agents}
        numbers["--test-steps"] = self.test_steps
        return [word for name, value in numbers.items() for word in (name, str(value))]


@dataclass(frozen=True)
class Entry:
    """A run of the list."""

    contender: Contender
    seed: int
    is_cold: bool = False

    @property
    def name(self) -> str:
        """Name of its file, without suffix."""
        return f"{self.contender.name}-{self.seed}" + "-cold" * self.is_cold

    @property
    def most_s(self) -> float:
        """Approximate longest duration."""
        return COLD_S if self.is_cold else self.contender.budget_s + OVERHEAD_S


def warm_entries(contenders: Sequence[Contender], seeds: int) -> list[Entry]:
    """The warm runs: for each seed, all contenders in turn."""
    return [Entry(contender, seed) for seed in range(seeds) for contender in contenders]


def cold_entries(contenders: Sequence[Contender], seeds: int) -> list[Entry]:
    """The cold runs: for each seed, the contenders of `COLD` in turn."""
    racing = [contender for contender in contenders if contender.name in COLD]
    return [Entry(contender, seed, is_cold=True) for seed in range(seeds) for contender in racing]


def run_all(entries: Sequence[Entry], out: Path, scale: Scale) -> None:
    """Do the runs that have no record yet.

    Raises:
        SystemExit: a run failed; the next call begins with it.
    """
    out.mkdir(parents=True, exist_ok=True)
    for number, entry in enumerate(entries, 1):
        path = out / f"{entry.name}.json"
        if _is_done(path, entry, scale):
            continue
        print(f"{number}/{len(entries)} {entry.name}", file=sys.stderr, flush=True)
        write_atomically(path, _line_of(entry, scale).encode())


def _is_done(path: Path, entry: Entry, scale: Scale) -> bool:
    """Whether a record exists for this contender's present settings and time limit."""
    contender = entry.contender if entry.is_cold else scale.limited(entry.contender)
    return path.exists() and read_record(path)["settings"] == contender.settings_hash


def _line_of(entry: Entry, scale: Scale) -> str:
    """Do a run in a child process on the contender's cores; returns the line of its record."""
    command = [sys.executable, str(PROGRAM), "--child", entry.contender.name]
    command += ["--seed", str(entry.seed), *scale.arguments]
    with tempfile.TemporaryDirectory() as empty:
        environment = dict(os.environ)
        if entry.is_cold:
            environment["NUMBA_CACHE_DIR"] = empty
            command += ["--started-s", str(time.monotonic())]
        done = on_cores(entry.contender.cores, command, environment)
    if done.returncode:
        raise SystemExit(f"learning: {entry.name} failed with exit status {done.returncode}")
    return done.stdout


def on_cores(
    cores: int, command: list[str], environment: dict[str, str] | None
) -> subprocess.CompletedProcess[str]:
    """Run a command on the first `cores` cores, which a child process inherits."""
    mine = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(mine)[:cores])
    try:
        return subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True)
    finally:
        os.sched_setaffinity(0, mine)
