"""Reading the file of a run: one JSON object."""

import json
import sys
from pathlib import Path
from typing import Any, NoReturn

_FIELDS = {"contender", "settings", "seed", "budget_s", "seconds", "looks"}


def read_record(path: Path) -> dict[str, Any]:
    """The record of a run.

    Raises:
        SystemExit: the file is not such a record; exit status 2, with one line on standard error.
    """
    try:
        record: Any = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        _refuse(path, str(error))
    if not isinstance(record, dict) or not record.keys() >= _FIELDS:
        _refuse(path, "something else")
    return dict(record)


def _refuse(path: Path, got: str) -> NoReturn:
    wanted = "expected the record of a run"
    print(f"learning: {path}: {wanted}, got {got}; remove it to run anew", file=sys.stderr)
    raise SystemExit(2)
