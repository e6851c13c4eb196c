"""A limit on how often something is said: at most once a period, by the caller's own clock."""

SECOND_NS = 1_000_000_000


class Throttle:
    """Tells its caller when the next message is due.

    Args:
        period_ns: the least time between two messages, nanoseconds.
        at_once: whether the first message is due at the first call; or a period after it.
    """

    def __init__(self, period_ns: int = SECOND_NS, *, at_once: bool = True) -> None:
        self._period_ns = period_ns
        self._at_once = at_once
        self._due_ns: int | None = None

    def is_due(self, now_ns: int) -> bool:
        """Whether a message is due now; if so, the next one is due a period later."""
        if self._due_ns is None:
            self._due_ns = now_ns if self._at_once else now_ns + self._period_ns
        if now_ns < self._due_ns:
            return False
        self._due_ns = now_ns + self._period_ns
        return True
