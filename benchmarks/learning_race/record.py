"""A run's file, as it was written: one object of JSON."""

import json
import sys
from pathlib import Path
from typing import Any, NoReturn

_FIELDS = {"contender", "settings", "seed", "budget_s", "seconds", "looks"}


def read_record(path: Path) -> dict[str, Any]:
    """What a file says of a run.

    Raises:
        SystemExit: it is no record; with a line that says so, exit status 2.
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
