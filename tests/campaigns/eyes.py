"""Bodies beside runtimes of another eye: is a tick ever OK on another's picture?

    python tests/campaigns/eyes.py [--pairs 200] [--seed 1] [--parallel 4] [--json]

Real processes. First, bodies that keep the eye of `sim --policy` serve runtime after runtime, each
of which differs in one field of the eye: no tick may be OK. Then as many that differ in seed,
scores, frames or names alone: all must drive. Last, bodies without a policy serve runtime after
runtime of random eyes: all must drive, by an eye that was built anew. Exit status 1 otherwise.
"""

import argparse
import json
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_runtime.contract.contract import PolicyContract
from support.eye_pairs import FIELDS, NOT_OF_THE_EYE, Pair, pairs
from support.fault_runs import free_ports
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started

TICKS = 75
"""Of each runtime: 1.5 s."""
ANEW_TICKS = 400
"""A body that is built anew may have to be compiled, and stands meanwhile."""
ATTEMPTS = 3
EACH = 10
"""Runtimes that one body serves."""


@dataclass
class Row:
    """All runtimes that differ in one thing."""

    what: str
    may_drive: bool
    runtimes: int = 0
    drove: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)

    def count(self, verdicts: dict[str, int]) -> None:
        self.runtimes += 1
        self.drove += verdicts.get("OK", 0) > 0
        self.verdicts.update(verdicts)

    @property
    def is_right(self) -> bool:
        return self.drove == (self.runtimes if self.may_drive else 0)


def served(group: Sequence[Pair], folder: Path, keeps: bool) -> list[tuple[str, dict[str, int]]]:
    """One body serves the runtimes of its pairs, one after the other: their verdicts."""
    (port,) = free_ports(1)
    mine = written(folder / f"{port}.onnx", group[0].body)
    words = ("--policy", mine) if keeps else ()
    found = []
    with started("sim", *words, "--port", port, "--json", cwd=folder) as body:
        said_line(body, "reference-1" if keeps else "waiting for a runtime")
        for number, pair in enumerate(group):
            policy = written(folder / f"{port}-{number}.onnx", pair.runtime)
            ticks = TICKS if keeps else ANEW_TICKS
            found.append((pair.field, verdicts_of(policy, port, ticks)))
        finished(body, signal.SIGINT)
    return found


def verdicts_of(policy: Path, port: int, ticks: int) -> dict[str, int]:
    """How a runtime judged so many ticks; one that a busy machine did not let begin is repeated."""
    words = ("run", policy, "--no-guard", "--no-watchdog", "--ticks", ticks)
    for _ in range(ATTEMPTS):
        done = reflexarc(*words, "--port", port, "--json")
        if done.returncode == 0:
            verdicts: dict[str, int] = json.loads(done.stdout.splitlines()[-1])["verdicts"]
            return verdicts
    raise AssertionError(done.stderr)


def written(path: Path, contract: PolicyContract) -> Path:
    path.write_bytes(exported(contract))
    return path


def in_groups(all_pairs: Iterator[Pair]) -> list[list[Pair]]:
    """The pairs of each body."""
    return [[*group] for _, group in groupby(all_pairs, lambda pair: id(pair.body))]


def campaign(count: int, seed: int, parallel: int, folder: Path) -> list[Row]:
    """Everything; the rows of the table."""
    bodies = max(1, count // EACH)
    rest = max(EACH, count // 10)
    parts = (
        ("", False, True, pairs(seed, count, FIELDS, bodies)),
        ("", True, True, pairs(seed + 1, rest, NOT_OF_THE_EYE, max(1, rest // EACH))),
        ("built anew: ", True, False, pairs(seed + 2, rest, FIELDS, max(1, rest // EACH))),
    )
    rows: dict[str, Row] = {}
    with ThreadPoolExecutor(parallel) as pool:
        for prefix, may_drive, keeps, some in parts:
            groups = in_groups(some)
            for found in pool.map(lambda g, k=keeps: served(g, folder, k), groups):
                for name, verdicts in found:
                    what = prefix + name
                    rows.setdefault(what, Row(what, may_drive)).count(verdicts)
    return list(rows.values())


def table(rows: Sequence[Row]) -> str:
    lines = ["| differs in | runtimes | drove | verdicts | right |", "|---|---|---|---|---|"]
    for row in rows:
        verdicts = ", ".join(f"{name} {n}" for name, n in row.verdicts.most_common())
        right = "yes" if row.is_right else "**no**"
        lines.append(f"| {row.what} | {row.runtimes} | {row.drove} | {verdicts} | {right} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--parallel", type=int, default=4)
    parser.add_argument("--json", action="store_true")
    flags: Any = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = campaign(flags.pairs, flags.seed, flags.parallel, Path(folder))
    if flags.json:
        print(json.dumps([{**vars(row), "right": row.is_right} for row in rows]))
    else:
        print(table(rows))
    return 0 if all(row.is_right for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
