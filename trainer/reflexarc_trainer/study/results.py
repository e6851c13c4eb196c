"""Results on the disk: one line of JSON a unit, each on the disk before the next one begins.

A process that is killed leaves whole lines and at most one torn one, which is not read and is cut
off by the next run. Only one process writes into a file.
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
    """A file of results, open for more; a context manager.

    Raises:
        UsageError: another process writes into it.
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
        """Keep a result; it is on the disk when this returns."""
        line = json.dumps(dataclasses.asdict(result)) + "\n"
        self._file.write(line.encode())
        self._file.flush()
        os.fsync(self._file.fileno())

    def _cut_torn_line(self) -> None:
        self._file.seek(0)
        content = self._file.read()
        self._file.truncate(content.rfind(b"\n") + 1)


def read_results(path: Path) -> list[Result]:
    """All whole results of a file, none if there is no file; what this version cannot read is left.

    Raises:
        OSError: the file is there and cannot be read.
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
    """The results of these units, by the units' hashes; the last of equals.

    Args:
        results: any.
        units: what is asked.
        code: results of other code are left out; "" takes those of any.
    """
    asked = {unit.hash for unit in units}
    fitting = (r for r in results if r.unit in asked and code in ("", r.code))
    return {result.unit: result for result in fitting}
