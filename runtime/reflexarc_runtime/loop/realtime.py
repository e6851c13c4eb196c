"""Settings of the process that let a loop wake on time, and which of them were granted.

Without privileges: a timer slack of 1 ns (the kernel's default of 50 µs is most of the lateness of
an idle machine), and start-up objects that the garbage collector no longer visits. With
privileges, if a priority is given: first-in-first-out scheduling.
"""

import ctypes
import gc
import os

_PR_SET_TIMERSLACK = 29


def prepare(fifo_priority: int = 0) -> list[str]:
    """Prepare this thread for a loop at a fixed rate.

    Args:
        fifo_priority: 1 to 99 for SCHED_FIFO; 0 leaves the scheduling as it is.

    Returns:
        What was obtained, and what was refused, a phrase each.
    """
    gc.collect()
    gc.freeze()
    said = [_set_timer_slack()]
    if fifo_priority:
        said.append(_set_fifo(fifo_priority))
    return said


def _set_timer_slack() -> str:
    try:
        refused = ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    except (AttributeError, OSError):
        refused = True
    return "timer slack unchanged (refused)" if refused else "timer slack 1 ns"


def _set_fifo(priority: int) -> str:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError) as error:
        return f"SCHED_FIFO {priority} refused ({error})"
    return f"SCHED_FIFO {priority}"
