"""Real logs, cut at random bytes and with random bits flipped: does replay ever say what is not so?

    python tests/campaigns/flips.py LOG… [--cuts 2000] [--flips 5000] [--seed 1]

In one process. Each damaged log is replayed where it can be read at all, and so is what `recover`
makes of it. Every second trial is of the same log without a CRC, as other tools write them, so that
a flipped bit reaches the replay. The status is 1 if anything was said that is not so.
"""

import argparse
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from support.flip_judge import FlipJudge, without_checks


def main() -> int:
    """Try them all and print the counts."""
    arguments = _arguments()
    dice, wrong = random.Random(arguments.seed), 0
    with tempfile.TemporaryDirectory() as folder:
        judges = [*_judges(arguments.logs, Path(folder))]
        for kind, count in (("cut", arguments.cuts), ("flip", arguments.flips)):
            for number in range(count):
                judge = judges[number % len(judges)]
                found = judge.cut(dice) if kind == "cut" else judge.flip(dice)
                wrong += len(found)
                for line in found:
                    print(f"WRONG  {judge.path.name}: {line}", flush=True)
            print(f"{count} × {kind}:", _total(judges))
    return int(wrong > 0)


def _judges(logs: list[Path], folder: Path) -> list[FlipJudge]:
    judges = []
    for number, log in enumerate(logs):
        plain = without_checks(log, folder / f"{number}-without-crc-{log.name}")
        judges += [FlipJudge(log, folder), FlipJudge(plain, folder)]
    return judges


def _total(judges: list[FlipJudge]) -> str:
    seen = sum((judge.seen for judge in judges), Counter[str]())
    for judge in judges:
        judge.seen.clear()
    return ", ".join(f"{name} {count}" for name, count in sorted(seen.items()))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("logs", type=Path, nargs="+")
    parser.add_argument("--cuts", type=int, default=2000)
    parser.add_argument("--flips", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
