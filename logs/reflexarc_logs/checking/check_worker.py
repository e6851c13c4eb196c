"""A worker of checks: `python -m reflexarc_logs.checking.check_worker`."""

import dataclasses
from pathlib import Path
from typing import Any

from reflexarc_logs.checking.check import check
from reflexarc_runtime.crew.worker import serve


def main() -> None:
    """Check logs until the input ends."""
    serve(_do, "checks")


def _do(plain: dict[str, Any]) -> dict[str, Any]:
    return dataclasses.asdict(check(Path(plain["path"])))


if __name__ == "__main__":
    main()
