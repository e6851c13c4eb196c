"""A bell: one thread waits for it, any thread rings it, and it is never rung in vain.

Its wait must not hang on the wall clock: one that is set back by an hour would let a loop stand for
an hour. Locks wait by the monotonic clock where Python was built with `sem_clockwait` (glibc 2.30);
older builds, which run on newer systems as well, take their time-outs from the wall clock.
"""

import functools
import os
import select
import sys
import threading
import weakref
from contextlib import suppress
from typing import Protocol


class Bell(Protocol):
    """Wakes one waiting thread at the first ring since it was heard last."""

    def ring(self) -> None:
        """Wake whoever waits, now or later; from any thread. A second ring changes nothing."""
        ...

    def hush(self) -> None:
        """Forget that it was rung."""
        ...

    def heard(self, timeout_s: float) -> bool:
        """Wait until it is rung, or for so long; whether it was. It is silent afterwards."""
        ...


def new_bell() -> Bell:
    """The quickest one that this Python can wait for whatever the wall clock does."""
    return LockBell() if locks_wait_steadily() else EventBell()


@functools.cache
def locks_wait_steadily() -> bool:
    """Whether the time-out of a lock ends when it should though the wall clock is set."""
    import sysconfig  # takes a millisecond of a start, of whoever waits for a bell

    return sys.platform != "linux" or bool(sysconfig.get_config_var("HAVE_SEM_CLOCKWAIT"))


class LockBell:
    """A lock that is taken while the bell is silent; see `Bell`.

    Of what Python offers, its time-out is woken as soon as any, and its ring costs least (a
    condition takes a lock more on both sides).
    """

    def __init__(self) -> None:
        self._silence = threading.Lock()
        self._silence.acquire()

    def ring(self) -> None:
        """See `Bell.ring`."""
        if self._silence.locked():
            try:
                self._silence.release()
            except RuntimeError:
                return  # another thread rang in between

    def hush(self) -> None:
        """See `Bell.hush`."""
        self._silence.acquire(blocking=False)

    def heard(self, timeout_s: float) -> bool:
        """See `Bell.heard`."""
        return self._silence.acquire(timeout=max(0.0, timeout_s))


class EventBell:
    """A counter in the kernel, above 0 once it is rung: eventfd(2); see `Bell`.

    It is about as quick, and costs a descriptor and two system calls more.
    """

    def __init__(self) -> None:
        self._rings = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        weakref.finalize(self, os.close, self._rings)

    def ring(self) -> None:
        """See `Bell.ring`."""
        with suppress(BlockingIOError):  # it was rung 2^64 times
            os.eventfd_write(self._rings, 1)

    def hush(self) -> None:
        """See `Bell.hush`."""
        self._take()

    def heard(self, timeout_s: float) -> bool:
        """See `Bell.heard`."""
        rung, _, _ = select.select([self._rings], [], [], max(0.0, timeout_s))
        return bool(rung) and self._take()

    def _take(self) -> bool:
        try:
            return os.eventfd_read(self._rings) > 0
        except BlockingIOError:
            return False
