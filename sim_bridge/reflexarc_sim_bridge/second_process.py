"""A second process that compiles one thing while this process compiles another.

Numba compiles one function at a time, so a thread would not help. What the other process compiles
it leaves in the cache, where this one finds it. If it fails, this one compiles all.
"""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator

_LONGEST_S = 300.0
"""A process that takes longer is stuck."""


def has_room() -> bool:
    """Whether there is a processor for it."""
    return len(os.sched_getaffinity(0)) > 1


@contextlib.contextmanager
def at_work(module: str, given: bytes) -> Iterator[None]:
    """Within it, and until it has ended, a process runs a module of ours.

    Args:
        module: its name.
        given: what it reads on its standard input.
    """
    helper = start(module, given)
    try:
        yield
    except BaseException:
        _stop(helper)
        raise
    if helper:
        with contextlib.suppress(subprocess.TimeoutExpired):
            helper.wait(_LONGEST_S)
        _stop(helper)


def start(module: str, given: bytes) -> subprocess.Popen[bytes] | None:
    """Start it; None if that fails."""
    command, silent = [sys.executable, "-m", module], subprocess.DEVNULL
    try:
        helper = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silent, stderr=silent)
        assert helper.stdin is not None, "a pipe was asked for"
        with helper.stdin as pipe:
            pipe.write(given)
    except OSError:  # no such process any more, or none to be had
        return None
    return helper


def _stop(helper: subprocess.Popen[bytes] | None) -> None:
    if helper:
        helper.kill()
        helper.wait()
