"""A timer of the kernel's that ends this process unless it is wound again in time.

A thread of Python's cannot run while another one holds the interpreter's lock. The kernel needs no
lock: when the timer runs out it sends SIGALRM, whose default action ends the process. Before that,
`faulthandler`, which is C and needs no lock either, writes where the main thread was. Of that one
alone: others may run meanwhile, and looking at their frames without the lock can crash.

The clock goes on while a process is stopped (SIGSTOP): one that is continued later than that ends.
"""

import contextlib
import faulthandler
import signal
from types import TracebackType
from typing import Any, Self


class KernelTimer:
    """A context manager; it is off until it is wound. Only for the main thread.

    Args:
        budget_s: the process lives so long after the loop was here last, and up to a quarter more:
            the kernel is asked four times within a budget, and not at every tick.
    """

    def __init__(self, budget_s: float) -> None:
        self._quarter_ns = round(budget_s * 1e9 / 4)
        self._longest_s = budget_s * 1.25
        self._next_ns = 0
        self._before: Any = None

    def __enter__(self) -> Self:
        self._before = signal.signal(signal.SIGALRM, signal.SIG_DFL)
        with contextlib.suppress(OSError, ValueError, AttributeError, RuntimeError):  # no stderr
            faulthandler.register(signal.SIGALRM, all_threads=False, chain=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        faulthandler.unregister(signal.SIGALRM)
        signal.signal(signal.SIGALRM, self._before)

    def wind(self, now_ns: int) -> None:
        """Begin the budget anew."""
        if now_ns >= self._next_ns:
            signal.setitimer(signal.ITIMER_REAL, self._longest_s)
            self._next_ns = now_ns + self._quarter_ns
