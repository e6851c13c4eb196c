"""A benchmark of two checkouts in turns: the comparison holds while the machine's speed moves.

    python benchmarks/in_turns.py ../before -- world.py
    python benchmarks/in_turns.py ../before --rounds 5 -- learner.py

Both checkouts need an environment of their own (`make .venv/.installed`). Each round runs the
benchmark once in the other checkout and once in this one, with `--json`. Printed are, for each
figure, the medians of both and the median over rounds of this one's ratio to the other's.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[1]


def figures(document: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a JSON document with the words that lead to it."""
    if isinstance(document, dict):
        words = " ".join(str(v) for v in document.values() if isinstance(v, str | bool))
        for name, value in document.items():
            yield from figures(value, f"{path} {words} {name}".strip())
    elif isinstance(document, list):
        for number, value in enumerate(document):
            yield from figures(value, f"{path} {number}")
    elif isinstance(document, int | float) and not isinstance(document, bool):
        yield path, float(document)


def run(checkout: Path, benchmark: list[str]) -> dict[str, float]:
    """The figures of one run."""
    python = checkout / ".venv" / "bin" / "python"
    script, *options = benchmark
    command = [str(python), f"benchmarks/{script}", *options, "--json"]
    environment = {name: v for name, v in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=checkout, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(
            f"in_turns: {' '.join(command)} in {checkout} ended with {done.returncode}"
        )
    return dict(figures(json.loads(done.stdout)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_Plain)
    parser.add_argument("other", type=Path, help="the other checkout")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("benchmark", nargs="+", help="a file of benchmarks/, and its options")
    options = parser.parse_args()
    rounds = []
    for number in range(options.rounds):
        print(f"round {number + 1} of {options.rounds} …", file=sys.stderr)
        rounds.append([run(each.resolve(), options.benchmark) for each in (options.other, HERE)])
    for name in rounds[0][0]:
        pairs = [(other[name], this[name]) for other, this in rounds if name in this]
        if not pairs or not all(other for other, _ in pairs):
            continue
        medians = [statistics.median(column) for column in zip(*pairs, strict=True)]
        ratio = statistics.median(this / other for other, this in pairs)
        print(f"{name:<60} {medians[0]:12.4g} {medians[1]:12.4g}  ratio {ratio:.3f}")


class _Plain(argparse.RawDescriptionHelpFormatter):
    """The description as it is written above."""


if __name__ == "__main__":
    main()
