"""The parts of one recording: another one begins when a disk can take it again, when one is full,
or when something happened that a black box writes down.
"""

import os
import time
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path

from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import PART_OF, Head, Part, next_path
from reflexarc_logs.recording.place import LostPlaceError, NoRoomError, Place
from reflexarc_logs.recording.shelves.shelf import Shelf
from reflexarc_logs.recording.syncer import DiskTask, Syncer
from reflexarc_runtime.errors import LogError

RETRY_S = 1.0
MOST_RETRY_S = 60.0
SHORT_PART_S = 10.0
"""A part that lasted less is no success: the next one waits twice as long."""
FIRST: Mapping[str, str] = {}


class Series:
    """Begins one part after another.

    Args:
        place: the first part; or a folder, in which it gets a name of its own.
        head: what each begins with.
        keeping: how it is kept.
        at_once: whether the first part is begun now; a black box has none yet.

    Raises:
        LogError: the first part exists, cannot be written, or there is no room.
    """

    def __init__(self, place: Path, head: Head, keeping: Keeping, *, at_once: bool = True) -> None:
        self._head, self._keeping = head, keeping
        kind = "whole run" if at_once else "black box"
        self._shelf = Shelf(place, keeping, head.run.run_id, kind)
        self.path = self._shelf.first
        self._place = Place(self.path, keeping.reserve_bytes)
        self._number = 0
        self._retry_s = RETRY_S
        self._begun_s = time.monotonic()
        self._due_s = 0.0
        self.syncer = Syncer()
        self._settling: deque[tuple[int, Part, DiskTask]] = deque()
        self._ended: list[Path] = []
        self.current: Part | None = None
        self.refusal = ""
        """Why the last attempt to begin a part came to nothing."""
        try:
            self._start(at_once=at_once)
        except BaseException:
            self._shelf.close()
            raise

    def _start(self, *, at_once: bool) -> None:
        if at_once:
            self._enter(self._part(self.path, None), 1, "")
        else:
            self._check_free()

    def close(self) -> None:
        """No part will be begun any more, and none is open."""
        self.syncer.end()
        self._shelf.close()

    @property
    def paths(self) -> tuple[Path, ...]:
        """Of all parts, under the names that they have now."""
        still = [part for _, part, _ in self._settling]
        still += [] if self.current is None else [self.current]
        return (*self._ended, *(part.place_now for part in still))

    def settle(self) -> None:
        """Let the current part, which is sealed, become durable and get its name."""
        part, self.current = self.current, None
        if part is not None:
            self._settling.append((self._number, part, self.syncer.do(part.settle)))

    def settled(self, *, wait: bool = False) -> Iterator[tuple[Part, Exception]]:
        """Take note of the parts that have their names by now; those that did not get theirs.

        Args:
            wait: for all of them.
        """
        while self._settling and (wait or self._settling[0][2].is_done):
            number, part, task = self._settling[0]
            task.wait()
            self._settling.popleft()
            error = task.error
            if error is not None:
                part.abandon()
                yield part, error
            self._shelve(number, part, "" if error is None else in_words(error))

    def failed(self, why: str = "") -> None:
        """Take note that the current part failed."""
        now_s = time.monotonic()
        short = now_s - self._begun_s < SHORT_PART_S and self._number > 1
        self._retry_s = min(2 * self._retry_s, MOST_RETRY_S) if short else RETRY_S
        self._due_s = now_s + self._retry_s
        part, self.current = self.current, None
        if part is not None:
            self._shelve(self._number, part, why or "it failed")

    def make_room(self) -> None:
        """Remove the oldest parts, if all together are too large."""
        self._shelf.make_room(self.current.size_bytes if self.current else 0)

    def begin(self, after: str, lost: int, why: Mapping[str, str] = FIRST) -> Part | None:
        """Begin the next part after a failure, if the disk can take it now; else None.

        Args:
            after: why the last one ended.
            lost: how many records were lost since.
            why: more that it says of itself.
        """
        if time.monotonic() < self._due_s:
            return None
        self._due_s = time.monotonic() + RETRY_S
        return self._next({"after": after, "lost": str(lost), **why}, after_failure=True)

    def go_on(self, about: Mapping[str, str]) -> Part | None:
        """Begin the next part where nothing failed; None if the disk does not take it.

        Args:
            about: what it says of itself.
        """
        return self._next({"lost": "0", **about}, after_failure=False)

    def _next(self, about: Mapping[str, str], *, after_failure: bool) -> Part | None:
        try:
            self._place.check_ready(twice=after_failure)
            path, number = self._name()
            said = {"part": str(number), PART_OF: self.path.name, **about}
            self._enter(self._part(path, said), number, _reason(about))
        except (OSError, LogError, LostPlaceError, NoRoomError) as error:
            self.refusal = in_words(error)
            return None
        return self.current

    def _part(self, path: Path, said: Mapping[str, str] | None) -> Part:
        return Part(path, self._head, self._place, said, self._keeping.sync_s, self.syncer)

    def _name(self) -> tuple[Path, int]:
        if not self._number:
            return self.path, 1
        named = next_path(self.path, self._number + 1)
        if named is None:
            raise LogError("no further name for a part")
        return named

    def _enter(self, part: Part, number: int, why: str) -> None:
        self._number, self._begun_s = number, time.monotonic()
        self.current = part
        self._shelf.begun(number, part.path, why)

    def _shelve(self, number: int, part: Part, why: str) -> None:
        """Keep its name only: an index grows with its log."""
        self._ended.append(part.place_now)
        self._shelf.ended(number, part.path, part.place_now, why)

    def _check_free(self) -> None:
        """Refuse at once what could not be written when it matters."""
        partial = self.path.with_name(self.path.name + PARTIAL)
        for place in (self.path, partial):
            if os.path.lexists(place):
                raise LogError(f"{place}: exists already; choose another name or remove it")
        try:
            self._place.check_ready(twice=False)
        except (OSError, NoRoomError) as error:
            raise LogError(f"{self.path}: cannot be written: {error}") from None
        if not os.access(self.path.parent, os.W_OK | os.X_OK):
            raise LogError(f"{self.path}: cannot be written: Permission denied")


def in_words(error: Exception) -> str:
    """What went wrong, as the system says it."""
    if isinstance(error, OSError):
        return error.strerror or repr(error)
    return str(error) if isinstance(error, LogError | LostPlaceError | NoRoomError) else repr(error)


def _reason(about: Mapping[str, str]) -> str:
    return about.get("trigger") or about.get("after", "")
