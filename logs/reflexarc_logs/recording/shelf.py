"""What is there of a recording's parts: the manifest tells of it, and the oldest make room.

Only what this recording wrote is ever removed: a part whose name leads to another file by now, by
device and inode, is left alone.
"""

import logging
import os
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.container.manifest import Manifest, PartEvent
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_runtime.errors import LogError

_LOG = logging.getLogger("reflexarc_logs.recording")


@dataclass(frozen=True)
class _Shelved:
    """A part that ended."""

    number: int
    name: str
    path: Path
    size_bytes: int
    identity: tuple[int, int]


class Shelf:
    """Keeps account of the parts of one recording.

    A recording in one piece has no manifest, unless parts were asked for.

    Args:
        first: the first part.
        keeping: how much is kept.
        run_id: whose recording it is.

    Raises:
        LogError: the manifest of another recording is there.
    """

    def __init__(self, first: Path, keeping: Keeping, run_id: str) -> None:
        self._keeping = keeping
        self._manifest = Manifest(first, run_id)
        self._shelved: deque[_Shelved] = deque()
        self._has_complained = False
        if keeping.in_parts and os.path.lexists(self._manifest.path):
            raise LogError(
                f"{self._manifest.path}: parts of another recording are there; "
                "choose another name or remove them"
            )

    def begun(self, number: int, path: Path, why: str) -> None:
        """Take note of a part that was begun."""
        self._say("begun", number, path.name, after=why)
        if self._keeping.in_parts or number > 1:
            self._trying(self._manifest.begin)

    def ended(self, number: int, path: Path, place: Path, why: str = "") -> None:
        """Take note of a part that ended.

        Args:
            number: of the part.
            path: its name when it is finished.
            place: the name that it has now.
            why: it failed; empty if it did not.
        """
        size_bytes = 0
        try:
            found = place.stat(follow_symlinks=False)
        except OSError:  # deleted, or out of reach: nothing to keep
            pass
        else:
            size_bytes, identity = found.st_size, (found.st_dev, found.st_ino)
            self._shelved.append(_Shelved(number, path.name, place, size_bytes, identity))
        event: PartEvent = "failed" if why else "finished"
        self._say(event, number, path.name, bytes=size_bytes, why=why)

    def make_room(self, current_bytes: int) -> None:
        """Remove the oldest parts until all have no more than they may.

        Args:
            current_bytes: size of the part that is being written, which is never removed.
        """
        keep_bytes = self._keeping.keep_bytes
        if keep_bytes is None:
            return
        total = current_bytes + sum(part.size_bytes for part in self._shelved)
        while total > keep_bytes and self._shelved:
            oldest = self._shelved.popleft()
            total -= oldest.size_bytes
            self._remove(oldest, f"all parts had more than {keep_bytes / (1 << 20):g} MB")

    def _remove(self, part: _Shelved, why: str) -> None:
        event: PartEvent = "left"
        try:
            found = part.path.stat(follow_symlinks=False)
            if (found.st_dev, found.st_ino) == part.identity:
                part.path.unlink()
                event = "removed"
            else:
                why = "another file has its name"
        except FileNotFoundError:
            why = "somebody removed or renamed it before"
        except OSError as error:
            why = error.strerror or repr(error)
        who = self._keeping.who
        self._say(event, part.number, part.name, bytes=part.size_bytes, by=who, why=why)

    def _say(self, event: PartEvent, number: int, name: str, **facts: str | int) -> None:
        told = {key: fact for key, fact in facts.items() if fact != ""}
        self._trying(lambda: self._manifest.say(event, part=number, name=name, **told))

    def _trying(self, write: Callable[[], None]) -> None:
        """A manifest that cannot be written ends no recording: every part says of which it is."""
        try:
            write()
        except OSError as error:
            if not self._has_complained:
                _LOG.warning("%s: cannot be written: %s", self._manifest.path, error.strerror)
            self._has_complained = True
