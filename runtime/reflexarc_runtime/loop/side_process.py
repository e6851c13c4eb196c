"""A process beside a loop: it works for the loop, comes after it, and ends with it."""

import ctypes
import os
import signal
from contextlib import suppress

NICE = 10
"""The loop and the body come first."""
_PR_SET_PDEATHSIG = 1


def serve_the_loop() -> None:
    """Leave signals for the whole group to the loop, end when it does, and let it go first."""
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(each, signal.SIG_IGN)
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    with suppress(OSError):
        os.nice(NICE)
    with suppress(AttributeError, OSError):  # else it interrupts the loop that has just woken it
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
