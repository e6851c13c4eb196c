"""What earlier recordings left in a folder: it counts, and makes room first, the oldest first.

Whose file is removed? One that a manifest of the folder names; whose recording was given this
folder and is of the same kind; whose recorder no longer lives (nobody holds the lock on the
manifest); and in which the log itself says that it is this part of this run. A finished part has
the size that the manifest says: one that somebody changed is theirs.
"""

import contextlib
import stat
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_logs.container.file_lock import FileLock
from reflexarc_logs.container.manifest import (
    MANIFEST,
    ListedPart,
    ListedRecording,
    Manifest,
    read_head,
    read_recording,
    say_in,
)
from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_logs.recording.shelves.part_head import says_it_is
from reflexarc_logs.recording.shelves.shelved import Shelved, removed, shelved
from reflexarc_runtime.errors import LogError


@dataclass
class _Recording:
    """One that has ended, and what is there of it."""

    manifest: Path
    run_id: str
    number: int
    parts: deque[Shelved] = field(default_factory=deque)


class EarlierRecordings:
    """What is there of them when the folder is looked at.

    Args:
        ours: the manifest of the recording for which room is made; it tells of it.
        kind: of the recordings that count.
        who: removes what is too much, for the manifests.
    """

    def __init__(self, ours: Manifest, kind: str, who: str) -> None:
        self._ours = ours
        found = sorted(_ended(ours.path, kind), key=lambda one: (one.number, one.manifest.name))
        self._who = who
        self._recordings = deque(one for one in found if one.parts or not self._forgets(one))
        self.size_bytes = sum(part.size_bytes for one in found for part in one.parts)
        """Of all that is there of them."""

    def remove_oldest(self, why: str) -> bool:
        """Remove the oldest part; False: there is none.

        Raises:
            OSError: our manifest did not take the word of it; the part is gone all the same.
        """
        while self._recordings and not self._recordings[0].parts:
            self._recordings.popleft()
        if not self._recordings:
            return False
        oldest = self._recordings[0]
        part = oldest.parts.popleft()
        self.size_bytes -= part.size_bytes
        self._remove(oldest, part, why)
        if not oldest.parts:
            self._forgets(oldest)
        return True

    def _remove(self, of: _Recording, part: Shelved, why: str) -> None:
        event, why = removed(part, why, lambda: says_it_is(part.path, of.run_id, part.number))
        facts: dict[str, str | int] = {"name": part.name, "bytes": part.size_bytes}
        facts |= {"by": self._who, "why": why}
        with contextlib.suppress(OSError):  # ours tells of it as well
            say_in(of.manifest, event, part=part.number, **facts)
        if event == "removed":
            self._ours.say("removed before", of=of.manifest.name, **facts)

    def _forgets(self, of: _Recording) -> bool:
        """Remove the manifest of which no part is left; what was left alone keeps it."""
        with contextlib.suppress(LogError, OSError), ExitStack() as stack:
            stack.enter_context(_taken(of.manifest))
            if any(_places(part) for part in read_recording(of.manifest).parts):
                return False
            of.manifest.unlink()
            why = "all of its parts are gone"
            self._ours.say("forgotten", name=of.manifest.name, by=self._who, why=why)
            return True
        return False


def _ended(ours: Path, kind: str) -> Iterator[_Recording]:
    for manifest in ours.parent.glob(f"*{MANIFEST}"):
        if manifest != ours and read_head(manifest).folder == kind:
            # What cannot be read names no file; what is locked is a living recorder's.
            with contextlib.suppress(LogError, OSError), _taken(manifest):
                said = read_recording(manifest)
                yield _Recording(manifest, said.run_id, said.number, deque(_there(said)))


def _taken(manifest: Path) -> FileLock:
    """The lock of a recorder that no longer lives.

    Raises:
        OSError: it lives, or nobody can tell.
    """
    lock = FileLock.taken(manifest)
    if lock is None:
        raise BlockingIOError
    return lock


def _there(said: ListedRecording) -> Iterator[Shelved]:
    for part in said.parts:
        for place in _places(part):
            found = shelved(part.number, part.path.name, place)
            if _is_part(part, found, said.run_id):
                yield found


def _is_part(part: ListedPart, found: Shelved, run_id: str) -> bool:
    if part.state == "finished":
        return found.size_bytes == part.size_bytes
    return says_it_is(found.path, run_id, part.number)


def _places(part: ListedPart) -> list[Path]:
    """Where it may be: finished, not finished, or both, if somebody recovered it."""
    names = (part.path, part.path.with_name(part.path.name + PARTIAL))
    return [place for place in names if _is_file(place)]


def _is_file(place: Path) -> bool:
    try:
        return stat.S_ISREG(place.stat(follow_symlinks=False).st_mode)
    except OSError:
        return False
