"""How a recording that is given a folder gets a name of its own in it, before it writes a byte.

The first one of a folder `monday` is `monday.mcap`, every later one is called by its start, in
local time: `monday_2026-11-30_05-02-33.123.mcap`, and `…-2.mcap` if another one began in that
millisecond. A name is claimed by making its manifest, which only one process can, and locking it.
"""

import datetime
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from reflexarc_logs.container.file_lock import FileLock
from reflexarc_logs.container.manifest import MANIFEST, Manifest, manifest_of, read_head
from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_runtime.errors import LogError

_SUFFIX = ".mcap"


@dataclass(frozen=True)
class ClaimedName:
    """A name in a folder."""

    first: Path
    """The first part, which does not exist yet."""
    manifest: Manifest
    """Begun, and locked for as long as its recorder lives."""
    lock: FileLock


def claimed(folder: Path, kind: str, run_id: str) -> ClaimedName:
    """ClaimedName a name in a folder.

    Args:
        folder: it exists.
        kind: of the recording: which others of the folder are of one kind with it.
        run_id: whose recording it is.

    Raises:
        LogError: the folder cannot be written.
    """
    try:
        for first in _names(folder):
            partial = first.with_name(first.name + PARTIAL)
            lock = None if _is_there(first, partial) else FileLock.made(manifest_of(first))
            if lock is not None:
                return ClaimedName(first, _begun(first, kind, run_id, lock), lock)
    except OSError as error:
        raise LogError(f"{folder}: cannot be written: {error.strerror}") from None
    raise AssertionError("names never end")


def _is_there(*places: Path) -> bool:
    return any(place.exists() or place.is_symlink() for place in places)


def _names(folder: Path) -> Iterator[Path]:
    """Names for a recording, the best first."""
    stem = folder.resolve().name
    if next(folder.glob(f"*{MANIFEST}"), None) is None:
        yield folder / f"{stem}{_SUFFIX}"
    now = datetime.datetime.now().isoformat("_", "milliseconds").replace(":", "-")
    yield folder / f"{stem}_{now}{_SUFFIX}"
    for number in count(2):
        yield folder / f"{stem}_{now}-{number}{_SUFFIX}"


def _begun(first: Path, kind: str, run_id: str, lock: FileLock) -> Manifest:
    """A manifest on which nobody can hold a lock says of no folder: nobody removes its parts."""
    facts: dict[str, str | int] = {}
    if lock.is_sure:
        facts = {"folder": kind, "number": 1 + _greatest_number(first.parent)}
    manifest = Manifest(first, run_id, **facts)
    manifest.begin()
    return manifest


def _greatest_number(folder: Path) -> int:
    return max((read_head(path).number for path in folder.glob(f"*{MANIFEST}")), default=0)
