"""Which logs are meant by the files, folders and manifests that somebody names."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from reflexarc_logs.container.file_lock import is_held
from reflexarc_logs.container.first_look import is_folder
from reflexarc_logs.container.manifest import MANIFEST, read_manifest
from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_runtime.errors import LogError

SUFFIX = ".mcap"
_NUMBER = re.compile(r"(\d+)")


def log_paths(places: Iterable[Path | str]) -> tuple[Path, ...]:
    """The logs: files as they are named, folders with all `*.mcap` in them, sorted by path.

    Numbers in names are sorted as numbers: `a.part2.mcap` comes before `a.part10.mcap`. A manifest,
    `*.parts.jsonl`, stands for those of its recording's parts that are there and finished. Links
    are followed. A log that is named twice is one.

    Args:
        places: files, folders and manifests.

    Raises:
        LogError: a folder or a manifest that holds no log, or nothing is named.
    """
    found = tuple(dict.fromkeys(path for place in places for path in _in(Path(place))))
    if not found:
        raise LogError("expected a log (.mcap) or a folder of logs, got nothing")
    return found


def unfinished_in(folder: Path) -> tuple[Path, ...]:
    """Logs in a folder that were never finished, and that no living process writes.

    One that was recovered beside, under its finished name, is not among them.
    """
    found = (path for path in folder.rglob(f"*{SUFFIX}{PARTIAL}") if path.is_file())
    left = (path for path in found if not path.with_suffix("").exists() and not is_held(path))
    return tuple(sorted(left, key=_in_order))


def _in(place: Path) -> Iterator[Path]:
    if place.name.endswith(MANIFEST):
        logs = [part.path for part in read_manifest(place) if part.path.is_file()]
        if not logs:
            raise LogError(f"{place}: expected finished parts beside it, found none")
    elif is_folder(place):
        found = (p for p in place.rglob("*") if p.suffix.lower() == SUFFIX and p.is_file())
        logs = sorted(found, key=_in_order)
        if not logs:
            raise LogError(f"{place}: expected logs (*{SUFFIX}) in this folder, found none")
    else:
        logs = [place]
    yield from logs


def _in_order(path: Path) -> list[tuple[tuple[int, str], ...]]:
    """Sorts names folder by folder, numbers in them as numbers."""
    return [
        tuple((int(piece) if i % 2 else 0, piece) for i, piece in enumerate(_NUMBER.split(name)))
        for name in path.parts
    ]
