"""How far a recorder is behind what it is given; read from another thread without waiting."""

import time

BEHIND_S = 0.5
"""Being behind for so long is worth a word; a disk that hangs shows so, too. With the period of a
flush and that of the status it is said within two seconds."""


class Progress:
    """Remembers when its thread had last caught up."""

    def __init__(self) -> None:
        self.steps = 0
        """Grows while the thread does anything."""
        self._caught_up_s = time.monotonic()

    def step(self, *, is_idle: bool) -> None:
        """Say that the thread goes on, and whether it has nothing left to do."""
        self.steps += 1
        if is_idle:
            self._caught_up_s = time.monotonic()

    def behind_in_words(self, waiting: int) -> str:
        """For how long it has been behind; empty if it is not."""
        behind_s = time.monotonic() - self._caught_up_s
        if behind_s < BEHIND_S:
            return ""
        return f"the disk is slow: {waiting} records have been waiting for {behind_s:.1f} s"
