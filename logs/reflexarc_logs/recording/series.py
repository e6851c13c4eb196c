"""The parts of one recording: another one begins when a disk can take it again."""

import time
from pathlib import Path

from reflexarc_logs.recording.part import PART_OF, Head, Part, next_path
from reflexarc_logs.recording.place import LostPlaceError, NoRoomError, Place
from reflexarc_runtime.errors import LogError

RETRY_S = 1.0
MOST_RETRY_S = 60.0
SHORT_PART_S = 10.0
"""A part that lasted less is no success: the next one waits twice as long."""


class Series:
    """Begins one part after another.

    Args:
        path: the first part.
        head: what each begins with.
        reserve_bytes: what shall stay free.

    Raises:
        LogError: the first part exists, cannot be written, or there is no room.
    """

    def __init__(self, path: Path, head: Head, reserve_bytes: int) -> None:
        self._head = head
        self._place = Place(path, reserve_bytes)
        self._number = 1
        self._retry_s = RETRY_S
        self._begun_s = time.monotonic()
        self._due_s = 0.0
        self.current = Part(path, head, self._place)
        self.parts = [self.current]

    @property
    def paths(self) -> tuple[Path, ...]:
        """Of all parts, under the names that they have now."""
        return tuple(part.place_now for part in self.parts)

    def failed(self) -> None:
        """Take note that the current part failed."""
        now_s = time.monotonic()
        short = now_s - self._begun_s < SHORT_PART_S and len(self.parts) > 1
        self._retry_s = min(2 * self._retry_s, MOST_RETRY_S) if short else RETRY_S
        self._due_s = now_s + self._retry_s

    def begin(self, after: str, lost: int) -> Part | None:
        """Begin the next part, if the disk can take it now; else None.

        Args:
            after: why the last one ended.
            lost: how many records were lost since.
        """
        if time.monotonic() < self._due_s:
            return None
        self._due_s = time.monotonic() + RETRY_S
        try:
            self._place.check_ready()
            named = next_path(self.parts[0].path, self._number + 1)
            if named is None:
                return None
            path, number = named
            about = {"part": str(number), PART_OF: self.parts[0].path.name}
            part = Part(path, self._head, self._place, {**about, "after": after, "lost": str(lost)})
        except (OSError, LogError, LostPlaceError, NoRoomError):
            return None
        self._number, self._begun_s = number, time.monotonic()
        self.current = part
        self.parts.append(part)
        return part
