"""Real logs, cut at random bytes and with random bits flipped: does replay ever say what is not so?

    python tests/campaigns/flips.py LOG… [--cuts 2000] [--flips 5000] [--seed 1]

In one process. Each damaged log is replayed where it can be read at all, and so is what `recover`
makes of it. Every second trial is of the same log without a CRC, as other tools write them, so that
a flipped bit reaches the replay. The status is 1 if anything was said that is not so.

    python tests/campaigns/flips.py --framing [LOG…] [--every 1]

turns every bit (or one of so many) of what holds a file together: kinds, lengths, headers of
chunks, indexes. Of these logs, or of five small ones: ours, one as the MCAP library writes by
default, one with attachments between chunks, two without chunks. `recover` may lose nothing intact
and invent nothing, and no reader may take for whole what reads as something else. The judge is the
MCAP library.
"""

import argparse
import random
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import islice, repeat
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from support.flip_judge import FlipJudge, without_checks
from support.framing_judge import FramingJudge
from support.framing_logs import LAYOUTS


def main() -> int:
    """Try them all and print the counts."""
    arguments = _arguments()
    if arguments.framing:
        return _framing(arguments.logs, arguments.every)
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


def _framing(logs: list[Path], every: int) -> int:
    """Turn the bits of the framing of each log; logs side by side."""
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(2) as pool:
        if not logs:
            logs = [Path(folder) / f"{name}.mcap" for name in LAYOUTS]
            for log in logs:
                LAYOUTS[log.stem](log)
        wrong = sum(pool.map(_framing_of, logs, repeat(every)))
    return int(wrong > 0)


def _framing_of(log: Path, every: int) -> int:
    """How many flips of one log are treated wrongly."""
    with tempfile.TemporaryDirectory() as folder:
        judge, wrong, tried = FramingJudge(log, Path(folder)), 0, 0
        for flip in islice(judge.flips(), 0, None, every):
            tried += 1
            for fault in judge.faults(flip):
                wrong += 1
                print(f"WRONG  {log.name}: {flip}: {fault}", flush=True)
        statuses = ", ".join(f"{n} × {status}" for status, n in sorted(judge.statuses.items()))
        print(f"{log.name}: {tried} bits, {wrong} wrong; status {statuses}", flush=True)
    return wrong


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
    parser.add_argument("logs", type=Path, nargs="*")
    parser.add_argument("--framing", action="store_true", help="turn the bits of the framing")
    parser.add_argument("--every", type=int, default=1, help="of so many bits of framing one")
    parser.add_argument("--cuts", type=int, default=2000)
    parser.add_argument("--flips", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if not given.logs and not given.framing:
        parser.error("expected logs, or --framing")
    return given


if __name__ == "__main__":
    sys.exit(main())
