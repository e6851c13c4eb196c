"""The results file of a study: one line of JSON per result, each flushed to the disk at once.

A process that is killed leaves whole lines and at most one incomplete line at the end; reading
skips that line, and the next process that opens the file removes it. A lock keeps other processes
from writing.
"""

import dataclasses
import fcntl
import json
import os
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.unit import Result, Unit


class ResultsFile:
    """A results file, open for appending; a context manager that closes it.

    Raises:
        UsageError: another process has it open.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: BinaryIO = path.open("a+b")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise UsageError(f"{path.parent}: another study is running here; wait for it") from None
        self._cut_torn_line()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()

    def append(self, result: Result) -> None:
        """Append a result; it is on the disk when this returns."""
        line = json.dumps(dataclasses.asdict(result)) + "\n"
        self._file.write(line.encode())
        self._file.flush()
        os.fsync(self._file.fileno())

    def _cut_torn_line(self) -> None:
        self._file.seek(0)
        content = self._file.read()
        self._file.truncate(content.rfind(b"\n") + 1)


def read_results(path: Path) -> list[Result]:
    """The results of a file; lines that this version cannot read are skipped.

    Returns:
        The results in the order of the file; none if there is no file.

    Raises:
        OSError: the file exists and cannot be read.
    """
    if not path.exists():
        return []
    results = []
    for line in path.read_bytes().split(b"\n")[:-1]:
        try:
            results.append(Result.from_plain(json.loads(line)))
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
