"""The results file of a study: one line of JSON per result (see `crew/lines_file.py`)."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from reflexarc_runtime.crew.lines_file import LinesFile, read_lines
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.unit import Result, Unit


class ResultsFile(LinesFile):
    """A results file, open for appending; a context manager that closes it.

    Raises:
        UsageError: another process has it open.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "study")

    def append(self, result: Result) -> None:
        """Append a result; it is on the disk when this returns."""
        self.append_line(dataclasses.asdict(result))


def read_results(path: Path) -> list[Result]:
    """The results of a file; lines that this version cannot read are skipped.

    Returns:
        The results in the order of the file; none if there is no file.

    Raises:
        OSError: the file exists and cannot be read.
    """
    results = []
    for line in read_lines(path):
        try:
            results.append(Result.from_plain(line))
        except (ValueError, UsageError):
            continue
    return results


def matching(results: Sequence[Result], units: Sequence[Unit], code: str) -> dict[str, Result]:
    """The results of units, by the units' hashes; of several for one unit, the last.

    Args:
        results: to choose from.
        units: whose results are wanted.
        code: only results of this code (`Result.code`); "" for those of any code.
    """
    asked = {unit.hash for unit in units}
    fitting = (r for r in results if r.unit in asked and code in ("", r.code))
    return {result.unit: result for result in fitting}
