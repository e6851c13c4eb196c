"""Which runs there are, in which order; each in a process of its own, none twice.

A run is one file with one line of JSON, `NAME-SEED.json` or `NAME-SEED-cold.json`. It is written
when the run is over, and at once: a file that is there is whole.
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
"""About what a run takes beside its budget: start, warm-up, looks, test worlds."""
COLD_S = 60.0
"""About what a cold run takes."""


@dataclass(frozen=True)
class Scale:
    """How much is run and measured."""

    budget_s: float = 60.0
    test_agents: int = 4096
    test_steps: int = 2000

    def limited(self, contender: Contender) -> Contender:
        """The contender with no more than this time."""
        return replace(contender, budget_s=min(contender.budget_s, self.budget_s))

    @property
    def arguments(self) -> list[str]:
        """Of the command."""
        numbers = {"--budget-s": self.budget_s, "--test-agents": self.test_agents}
        numbers["--test-steps"] = self.test_steps
        return [word for name, value in numbers.items() for word in (name, str(value))]


@dataclass(frozen=True)
class Entry:
    """A run to be done."""

    contender: Contender
    seed: int
    is_cold: bool = False

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.contender.name}-{self.seed}" + "-cold" * self.is_cold

    @property
    def most_s(self) -> float:
        """About how long it takes at most."""
        return COLD_S if self.is_cold else self.contender.budget_s + OVERHEAD_S


def warm_entries(contenders: Sequence[Contender], seeds: int) -> list[Entry]:
    """Seed by seed, all contenders in turn."""
    return [Entry(contender, seed) for seed in range(seeds) for contender in contenders]


def cold_entries(contenders: Sequence[Contender], seeds: int) -> list[Entry]:
    """The same for those who start cold as well."""
    racing = [contender for contender in contenders if contender.name in COLD]
    return [Entry(contender, seed, is_cold=True) for seed in range(seeds) for contender in racing]


def run_all(entries: Sequence[Entry], out: Path, scale: Scale) -> None:
    """Do what is not done yet.

    Raises:
        SystemExit: a run failed; the next call goes on with it.
    """
    out.mkdir(parents=True, exist_ok=True)
    for number, entry in enumerate(entries, 1):
        path = out / f"{entry.name}.json"
        if _is_done(path, entry, scale):
            continue
        print(f"{number}/{len(entries)} {entry.name}", file=sys.stderr, flush=True)
        write_atomically(path, _line_of(entry, scale).encode())


def _is_done(path: Path, entry: Entry, scale: Scale) -> bool:
    """Whether there is a record of this contender as it is now, and of this length."""
    contender = entry.contender if entry.is_cold else scale.limited(entry.contender)
    return path.exists() and read_record(path)["settings"] == contender.settings_hash


def _line_of(entry: Entry, scale: Scale) -> str:
    """Run a child on the contender's cores, and return its line."""
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
    """Run a command on the first so many cores: a child inherits them."""
    mine = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(mine)[:cores])
    try:
        return subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True)
    finally:
        os.sched_setaffinity(0, mine)
