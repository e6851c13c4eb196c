"""Hostile files, each given to the commands that read such files; one row a command.

    python tests/campaigns/hostile [--only WORD] [--json]

No traceback, one line where the file is refused (status 2), under 10 s (on a busy machine:
of the processor), under 500 MB. Each module
here has a table `FILES` of functions that make one file each. The status is 1 if a row has a fault.
"""

import argparse
import importlib
import json
import pkgutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # the tests' support package
sys.path.insert(0, str(Path(__file__).parents[1]))

import hostile
from hostile.measured import Maker, Measured, measured


def main() -> int:
    """Try them all and print the table."""
    given = _arguments()
    rows = wrong = 0
    if not given.json:
        print("| file | command | status | s | of the processor | MB | what it said | faults |")
        print("|---|---|--:|--:|--:|--:|---|---|")
    for name, maker in _files(given.only):
        for command, seen in _tried(maker):
            rows, wrong = rows + 1, wrong + bool(seen.faults)
            print(_as_json(name, command, seen) if given.json else _row(name, command, seen))
            sys.stdout.flush()
    if not given.json:
        print(f"\n{rows} commands on hostile files, {wrong} of them with a fault")
    return 1 if wrong or not rows else 0


def _files(only: str) -> Iterator[tuple[str, Maker]]:
    """Every hostile file of every module here that has a table of them."""
    for module in sorted(info.name for info in pkgutil.iter_modules(hostile.__path__)):
        if module.startswith("__"):
            continue
        table = getattr(importlib.import_module(f"hostile.{module}"), "FILES", {})
        for name, maker in table.items():
            if only in f"{module}: {name}":
                yield f"{module}: {name}", maker


def _tried(maker: Maker) -> Iterator[tuple[str, Measured]]:
    """The commands for one file, each in a folder of its own, and how they ended."""
    with tempfile.TemporaryDirectory() as scratch:
        made = Path(scratch) / "made"
        made.mkdir()
        file, commands = maker(made)
        for number, command in enumerate(commands):
            place = Path(scratch) / str(number)
            place.mkdir()
            named = [
                w.replace("FILE", str(file)).replace("OUT", str(place / "out")) for w in command
            ]
            yield " ".join(command), measured(named, place)


def _row(name: str, command: str, seen: Measured) -> str:
    said = " ".join((seen.complaint or seen.out).split())[-160:].replace("|", "/")
    figures = f"{seen.status} | {seen.took_s:.1f} | {seen.cpu_s:.1f} | {seen.peak_bytes / 1e6:.0f}"
    faults = ", ".join(seen.faults) or "–"
    return f"| {name} | `{command}` | {figures} | {said} | {faults} |"


def _as_json(name: str, command: str, seen: Measured) -> str:
    return json.dumps({"file": name, "command": command, **asdict(seen), "faults": seen.faults})


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--only", default="", help="only what has this word in it")
    parser.add_argument("--json", action="store_true", help="one JSON object a row")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
