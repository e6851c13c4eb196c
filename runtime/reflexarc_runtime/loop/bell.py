"""A bell: one thread waits for it, any thread rings it, and it is never rung in vain."""

import threading


class Bell:
    """Wakes one waiting thread at the first ring since it was heard last.

    A lock that is taken while the bell is silent: of what Python offers, its time-out is woken as
    soon as any, and its ring costs least (a condition takes a lock more on both sides).
    """

    def __init__(self) -> None:
        self._silence = threading.Lock()
        self._silence.acquire()

    def ring(self) -> None:
        """Wake whoever waits, now or later; from any thread. A second ring changes nothing."""
        if self._silence.locked():
            try:
                self._silence.release()
            except RuntimeError:
                return  # another thread rang in between

    def hush(self) -> None:
        """Forget that it was rung."""
        self._silence.acquire(blocking=False)

    def heard(self, timeout_s: float) -> bool:
        """Wait until it is rung, or for so long; whether it was. It is silent afterwards."""
        return self._silence.acquire(timeout=max(0.0, timeout_s))
