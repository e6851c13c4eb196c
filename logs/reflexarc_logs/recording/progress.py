"""How far a recorder is behind what it is given; read from another thread without waiting."""

import time

BEHIND_S = 0.3
"""Being busy for so long is worth a word; a disk that hangs shows so, too. With the periods of a
sync and of the status it is said some two seconds after the disk became slow."""


class Progress:
    """Remembers since when its thread has had something to do."""

    def __init__(self) -> None:
        self.steps = 0
        """Grows while the thread does anything."""
        self._busy_since_s: float | None = None

    def rest(self) -> None:
        """Say that the thread has done all that there was to do, and waits."""
        self.steps += 1
        self._busy_since_s = None

    def work(self) -> None:
        """Say that it goes on."""
        self.steps += 1
        if self._busy_since_s is None:
            self._busy_since_s = time.monotonic()

    def behind_in_words(self, waiting: int, disk_since_s: float | None = None) -> str:
        """For how long it has not caught up; empty if it has, or not for long.

        Args:
            waiting: how many records wait.
            disk_since_s: since when the disk has been asked to sync and has not answered.
        """
        known = [t for t in (self._busy_since_s, disk_since_s) if t is not None]
        since_s = min(known) if known else None
        busy_s = 0.0 if since_s is None else time.monotonic() - since_s
        if busy_s < BEHIND_S:
            return ""
        return f"the disk is slow: busy for {busy_s:.1f} s, {waiting} records wait"
