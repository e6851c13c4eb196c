"""A benchmark of two checkouts in turns: the comparison holds while the machine's speed moves.

    python benchmarks/in_turns.py ../before -- world.py
    python benchmarks/in_turns.py ../before --rounds 5 -- learner.py

Both checkouts need an environment of their own (`make .venv/.installed`). Each round runs the
benchmark once in the other checkout and once in this one, with `--json`. Printed are, for each
figure, the medians of both and the median over rounds of this one's ratio to the other's. What
never differs is a setting and is left out. Exit status: 2 if nothing can be compared.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Never, TypeAlias

HERE = Path(__file__).resolve().parents[1]

Round: TypeAlias = tuple[dict[str, float], dict[str, float]]
"""The figures of the other checkout and of this one."""


def figures(document: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a JSON document with the words that lead to it."""
    if isinstance(document, dict):
        words = " ".join(str(v) for v in document.values() if isinstance(v, str | bool))
        for name, value in document.items():
            yield from figures(value, f"{path} {words} {name}".strip())
    elif isinstance(document, list):
        for number, value in enumerate(document):
            yield from figures(value, f"{path} {number}".strip())
    elif isinstance(document, int | float) and not isinstance(document, bool):
        yield path, float(document)


def compared(rounds: list[Round]) -> Iterator[str]:
    """A line for each figure that both sides have in every round and that ever differs."""
    for name in rounds[0][0]:
        if not all(name in other and name in this for other, this in rounds):
            continue
        pairs = [(other[name], this[name]) for other, this in rounds]
        if all(other == this for other, this in pairs) or not all(other for other, _ in pairs):
            continue
        medians = [statistics.median(column) for column in zip(*pairs, strict=True)]
        ratio = statistics.median(this / other for other, this in pairs)
        yield f"{name:<60} {medians[0]:12.4g} {medians[1]:12.4g}  ratio {ratio:.3f}"


def one_sided(rounds: list[Round]) -> Iterator[str]:
    """A line for each name that only one side has in the first round."""
    other, this = rounds[0]
    yield from (f"only in the other: {name}" for name in other if name not in this)
    yield from (f"only in this one: {name}" for name in this if name not in other)


def run(checkout: Path, benchmark: list[str]) -> dict[str, float]:
    """The figures of one run."""
    script, *options = benchmark
    command = [str(python_of(checkout)), f"benchmarks/{script}", *options, "--json"]
    environment = {name: v for name, v in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=checkout, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        refuse(f"{' '.join(command)} in {checkout} ended with {done.returncode}")
    try:
        return dict(figures(json.loads(done.stdout)))
    except json.JSONDecodeError:
        refuse(f"{' '.join(command)} in {checkout}: expected JSON, got {done.stdout[:40]!r}")


def python_of(checkout: Path) -> Path:
    """The interpreter of a checkout's own environment."""
    return checkout / ".venv" / "bin" / "python"


def refuse(words: str) -> Never:
    """Say what is wrong in one line, and end with status 2."""
    print(f"in_turns: {words}", file=sys.stderr)
    raise SystemExit(2)


def main() -> None:
    """Run the rounds, and print what can be compared."""
    options = parsed()
    checkouts = (options.other.resolve(), HERE)
    for checkout in checkouts:
        if not python_of(checkout).exists():
            refuse(f"{checkout}: expected a checkout with .venv; make .venv/.installed in it")
    rounds: list[Round] = []
    for number in range(options.rounds):
        print(f"round {number + 1} of {options.rounds} …", file=sys.stderr)
        other, this = (run(checkout, options.benchmark) for checkout in checkouts)
        rounds.append((other, this))
    for line in one_sided(rounds):
        print(line, file=sys.stderr)
    lines = list(compared(rounds))
    if not lines:
        refuse("expected figures that both checkouts have and that differ, found none")
    print(*lines, sep="\n")


def parsed() -> argparse.Namespace:
    """The options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=_Plain)
    parser.add_argument("other", type=Path, help="the other checkout")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("benchmark", nargs="+", help="a file of benchmarks/, and its options")
    options = parser.parse_args()
    if options.rounds < 1:
        refuse(f"--rounds: expected 1 or more, got {options.rounds}")
    return options


class _Plain(argparse.RawDescriptionHelpFormatter):
    """The description as it is written above."""


if __name__ == "__main__":
    main()
