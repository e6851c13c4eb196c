"""What is there of a recording's parts: the manifest tells of it, and the oldest make room.

Only what a recording wrote is ever removed: a part whose name leads to another file by now, by
device and inode, is left alone. In a folder of recordings the parts of earlier ones go first.
"""

import logging
import os
from collections import deque
from collections.abc import Callable
from pathlib import Path

from reflexarc_logs.container.file_lock import FileLock
from reflexarc_logs.container.first_look import is_folder
from reflexarc_logs.container.manifest import Manifest, PartEvent
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.shelves.claim import claimed
from reflexarc_logs.recording.shelves.earlier import EarlierRecordings
from reflexarc_logs.recording.shelves.shelved import BYTES_IN_MB, Shelved, removed, shelved
from reflexarc_runtime.errors import LogError

_LOG = logging.getLogger("reflexarc_logs.recording")


class Shelf:
    """Keeps account of the parts of one recording.

    A recording in one piece has no manifest, unless parts were asked for, or a folder was given.

    Args:
        place: the first part; or a folder, in which the recording gets a name of its own.
        keeping: how much is kept.
        run_id: whose recording it is.
        kind: of the recordings of a folder with which it shares what it may keep.

    Raises:
        LogError: the manifest of another recording is there, or the folder cannot be written.
    """

    def __init__(self, place: Path, keeping: Keeping, run_id: str, kind: str = "") -> None:
        self._keeping = keeping
        self._shelved: deque[Shelved] = deque()
        self._earlier: EarlierRecordings | None = None
        self._lock: FileLock | None = None
        self._has_complained = self._has_begun = False
        if is_folder(place):
            self._claim(place, kind, run_id)
        else:
            self.first, self._manifest = place, Manifest(place, run_id)
            self._check_is_first()

    def _claim(self, folder: Path, kind: str, run_id: str) -> None:
        claim = claimed(folder, kind, run_id)
        self.first, self._manifest, self._lock = claim.first, claim.manifest, claim.lock
        if self._keeping.keep_bytes is not None:
            self._earlier = EarlierRecordings(self._manifest, kind, self._keeping.who)
            self.make_room(0)

    def _check_is_first(self) -> None:
        if self._keeping.in_parts and os.path.lexists(self._manifest.path):
            raise LogError(
                f"{self._manifest.path}: parts of another recording are there; "
                "choose another name or remove them; or give a folder, which takes many"
            )

    def begun(self, number: int, path: Path, why: str) -> None:
        """Take note of a part that was begun."""
        self._has_begun = True
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
            part = shelved(number, path.name, place)
        except OSError:  # deleted, or out of reach: nothing to keep
            pass
        else:
            size_bytes = part.size_bytes
            self._shelved.append(part)
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
        why = f"all parts had more than {keep_bytes / BYTES_IN_MB:g} MB"
        while self._total_bytes(current_bytes) > keep_bytes and self._remove_oldest(why):
            pass

    def close(self) -> None:
        """The recording has ended; a manifest that tells of no part is removed."""
        lock, self._lock = self._lock, None
        if lock is None:
            return
        if not self._has_begun:
            self._trying(lambda: self._manifest.path.unlink(missing_ok=True))
        lock.close()

    def _total_bytes(self, current_bytes: int) -> int:
        earlier_bytes = 0 if self._earlier is None else self._earlier.size_bytes
        return current_bytes + earlier_bytes + sum(part.size_bytes for part in self._shelved)

    def _remove_oldest(self, why: str) -> bool:
        """Remove one part; False: there is none."""
        if self._earlier is not None and self._remove_earlier(self._earlier, why):
            return True
        if self._shelved:
            part = self._shelved.popleft()
            event, why = removed(part, why)
            by = self._keeping.who
            self._say(event, part.number, part.name, bytes=part.size_bytes, by=by, why=why)
            return True
        return False

    def _remove_earlier(self, earlier: EarlierRecordings, why: str) -> bool:
        try:
            return earlier.remove_oldest(why)
        except OSError as error:
            self._complain(error)
            return True

    def _say(self, event: PartEvent, number: int, name: str, **facts: str | int) -> None:
        told = {key: fact for key, fact in facts.items() if fact != ""}
        self._trying(lambda: self._manifest.say(event, part=number, name=name, **told))

    def _trying(self, write: Callable[[], object]) -> None:
        """A manifest that cannot be written ends no recording: every part says of which it is."""
        try:
            write()
        except OSError as error:
            self._complain(error)

    def _complain(self, error: OSError) -> None:
        if not self._has_complained:
            _LOG.warning("%s: cannot be written: %s", self._manifest.path, error.strerror)
        self._has_complained = True
