"""Thousands of files, each a good one that was changed at random, given to what reads such files.

    python tests/campaigns/mutants.py [--count 4000] [--first 0] [--jobs 2] [--kept FOLDER]

Policies, logs, worlds, lidar logs, images: flipped bits, cuts, runs put in, lengths that lie,
pieces swapped. Each ends well or with an error of one line, within 10 s of the processor and
500 MB. In worker processes that are used again; a mutant at which one dies, or that breaks
something, is kept in the folder. The status is 1 if there is one.
"""

import argparse
import os
import sys
from collections import Counter
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]  # this campaign's modules, the tests' support package

from reflexarc_runtime.crew.crew import Crew  # noqa: E402  # the tree that holds this file
from reflexarc_runtime.crew.worker_process import Done, Failure, Task  # noqa: E402

WORKER = "hostile.mutant_worker"


def main() -> int:
    """Try them all, print what is wrong, and the counts."""
    given = _arguments()
    given.kept.mkdir(parents=True, exist_ok=True)
    os.environ["PYTHONPATH"] = os.pathsep.join([*sys.path[:2], os.environ.get("PYTHONPATH", "")])
    numbers = range(given.first, given.first + given.count)
    tasks = [Task(str(n), {"number": n, "kept": str(given.kept.resolve())}) for n in numbers]
    wrong, seen, largest, longest_s = 0, Counter[str](), 0, 0.0
    with Crew(WORKER, tasks, given.jobs, first_alone=True) as crew:
        for outcome in crew.outcomes(lambda: False):
            fault = _fault_of(outcome)
            if fault:
                wrong += 1
                print(f"WRONG  {outcome.task.key}: {fault}", flush=True)
            if isinstance(outcome, Done):
                found = outcome.answer
                seen[f"{Path(found['file']).suffix[1:]} {found['how']}"] += 1
                largest = max(largest, found["peak"])
                longest_s = max(longest_s, found["took_s"])
    print(", ".join(f"{kind} {count}" for kind, count in sorted(seen.items())))
    print(
        f"{len(tasks)} mutants, {wrong} with a fault; the longest took {longest_s:.1f} s of the "
        f"processor, the largest {largest / 1e6:.0f} MB"
    )
    return 1 if wrong else 0


def _fault_of(outcome: Done | Failure) -> str:
    if isinstance(outcome, Failure):
        return outcome.reason
    found: dict[str, Any] = outcome.answer
    if found["how"] != "broken" and not found["faults"]:
        return ""
    figures = f"{found['took_s']:.1f} s, {found['peak'] / 1e6:.0f} MB"
    return f"{found['way']} ({found['file']}), {figures}: {found['said']}"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=4000)
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kept", type=Path, default=Path("runs/mutants"), help="for the faulty")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
