"""Which logs are meant by the files and folders that somebody names."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from reflexarc_runtime.errors import LogError

SUFFIX = ".mcap"


def log_paths(places: Iterable[Path | str]) -> tuple[Path, ...]:
    """The logs: files as they are named, folders with all `*.mcap` in them, sorted by path.

    Links are followed. A log that is named twice is one.

    Args:
        places: files and folders.

    Raises:
        LogError: a folder that holds no log, or nothing is named.
    """
    found = tuple(dict.fromkeys(path for place in places for path in _in(Path(place))))
    if not found:
        raise LogError("expected a log (.mcap) or a folder of logs, got nothing")
    return found


def _in(place: Path) -> Iterator[Path]:
    if not place.is_dir():
        yield place
        return
    logs = sorted(p for p in place.rglob("*") if p.suffix.lower() == SUFFIX and p.is_file())
    if not logs:
        raise LogError(f"{place}: expected logs (*{SUFFIX}) in this folder, found none")
    yield from logs
