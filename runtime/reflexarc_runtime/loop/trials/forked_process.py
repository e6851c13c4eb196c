"""A process that begins as a copy of this one: it has all modules at once, where a new one takes
longer to load them than to try a policy.

Only a process with a single thread is copied: a lock that another thread holds would be held in the
copy for ever. Whatever the copy does, it ends by itself, and can be ended; what it prints is read
as from any other process.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path

from reflexarc_runtime.loop.trials.trial import TrialProcess, spawned

_TASKS = Path("/proc/self/task")


def forked_if_alone(path: Path, backend: str, data: bytes | None = None) -> TrialProcess:
    """Begin a trial in a copy of this process, if it has one thread; else in a new one.

    Args: see `spawned`.
    """
    if not _is_alone():
        return spawned(path, backend, data)
    from reflexarc_runtime.loop.trials.trial_process import main

    return ForkedProcess(lambda: main(path, backend, data))


def _is_alone() -> bool:
    """Whether no other thread runs, of Python's or of a library's."""
    try:
        return len(list(_TASKS.iterdir())) == 1
    except OSError:  # no Linux
        return False


class ForkedProcess:
    """A copy of this process that does one thing: see `TrialProcess`.

    Args:
        act: what it does; it may print.
    """

    def __init__(self, act: Callable[[], None]) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        read_end, write_end = os.pipe()
        self._turn = threading.Lock()
        self.returncode: int | None = None
        self._pid = os.fork()
        if self._pid == 0:
            _become(act, write_end)
        os.close(write_end)
        self.stdout = open(read_end)  # noqa: SIM115  # whoever has the trial closes it

    def kill(self) -> None:
        """End it at once."""
        with self._turn:  # its number may be another's once its end was seen
            if self.returncode is None:
                os.kill(self._pid, signal.SIGKILL)

    def wait(self) -> int:
        """Wait for its end; its status, negative for a signal."""
        if self.returncode is None:
            os.waitid(os.P_PID, self._pid, os.WEXITED | os.WNOWAIT)
            with self._turn:
                _, status = os.waitpid(self._pid, 0)
                self.returncode = os.waitstatus_to_exitcode(status)
        return self.returncode

    def communicate(self) -> tuple[str, None]:
        """All that it has yet to print, once it has ended."""
        with self.stdout:
            said = self.stdout.read()
        self.wait()
        return said, None


def _become(act: Callable[[], None], write_end: int) -> None:
    """Do it in the copy, and end: nothing of what this process was in the midst of goes on."""
    status = 1
    try:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for standard, replacement in ((0, nowhere), (1, write_end), (2, nowhere)):
            os.dup2(replacement, standard)
        sys.stdout = os.fdopen(1, "w", closefd=False)
        act()
        sys.stdout.flush()
        status = 0
    finally:
        os._exit(status)
