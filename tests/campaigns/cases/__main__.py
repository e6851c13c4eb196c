"""Every circumstance of a folder of cases, and whether the right answer came.

    python tests/campaigns/cases FOLDER [--only WORD] [--json]

The folder holds one folder for each kind of input, with a README that names its source and the
right answer. Each line of the table is one circumstance, tried with real commands. The status is 1
if a right answer did not come.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # the tests' support package
sys.path.insert(0, str(Path(__file__).parents[1]))

from cases import FAMILIES
from cases.case import Case, Outcome, Stage


def main() -> int:
    """Try them all and print the table."""
    arguments = _arguments()
    missed = 0
    for case in _cases(arguments.only):
        outcome = _tried(case, arguments.folder)
        missed += not outcome.holds
        print(_line(case, outcome, arguments.json), flush=True)
    return int(missed > 0)


def _cases(only: str) -> Iterator[Case]:
    for family in FAMILIES:
        for case in family.CASES:
            if only in f"{family.__name__} {case.folder} {case.circumstance}":
                yield case


def _tried(case: Case, folder: Path) -> Outcome:
    """The outcome of one case; one that breaks has not shown that anything holds."""
    with tempfile.TemporaryDirectory() as scratch:
        try:
            return case.trial(Stage((folder / case.folder).resolve(), Path(scratch)))
        except Exception as error:
            return Outcome(False, f"it broke: {error!r}"[:300])


def _line(case: Case, outcome: Outcome, as_json: bool) -> str:
    if as_json:
        row = {"folder": case.folder, "circumstance": case.circumstance}
        seen = {"expected": case.expected, "holds": outcome.holds, "seen": outcome.seen}
        return json.dumps({**row, **seen})
    word = "right" if outcome.holds else "WRONG"
    return f"{word}  {case.folder or '–'}: {case.circumstance} → {outcome.seen}"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path, help="the folder of cases")
    parser.add_argument("--only", default="", help="only what has this word in it")
    parser.add_argument("--json", action="store_true", help="one JSON object a row")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
