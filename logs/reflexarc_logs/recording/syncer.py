"""Waits for the disk, in a thread of its own: a sync may take seconds, and what comes meanwhile
must be handed to the system all the same, or a kill would lose it.
"""

import queue
import threading
import time
from collections.abc import Callable


class DiskTask:
    """Something that the disk is asked for."""

    def __init__(self, act: Callable[[], None]) -> None:
        self._act = act
        self._done = threading.Event()
        self.begun_s = time.monotonic()
        self.took_s = 0.0
        self.error: Exception | None = None
        """Why it failed; read it once it is done."""

    @property
    def is_done(self) -> bool:
        """Whether the disk has answered."""
        return self._done.is_set()

    def run(self) -> None:
        """Do it, and remember what came of it."""
        try:
            self._act()
        except Exception as error:
            self.error = error
        self.took_s = time.monotonic() - self.begun_s
        self._done.set()

    def wait(self) -> None:
        """Wait until the disk has answered."""
        self._done.wait()


class Syncer:
    """Does one task after another."""

    def __init__(self) -> None:
        self._tasks: queue.SimpleQueue[DiskTask | None] = queue.SimpleQueue()
        self._last: DiskTask | None = None
        self._thread: threading.Thread | None = None

    @property
    def waits_since_s(self) -> float | None:
        """Since when the disk has not answered the last task; None: it has."""
        last = self._last
        return None if last is None or last.is_done else last.begun_s

    def do(self, act: Callable[[], None]) -> DiskTask:
        """Have something done behind all that was asked for before."""
        task = self._last = DiskTask(act)
        self._tasks.put(task)
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="syncer", daemon=True)
            self._thread.start()
        return task

    def end(self) -> None:
        """Say that nothing more will be asked for."""
        self._tasks.put(None)

    def _run(self) -> None:
        while (task := self._tasks.get()) is not None:
            task.run()
