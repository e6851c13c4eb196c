"""How far behind messages are, without comparing two clocks.

Arrival minus stamp is the difference of two clocks plus the time on the way. Its least value in
recent minutes stands for a message that came without waiting; what another one took longer, it
waited somewhere: a queue two seconds deep is two seconds old, however regularly it delivers.
"""

from dataclasses import dataclass

WINDOW_NS = 60_000_000_000
"""The least value counts for one to two windows: clocks of different speed drift apart."""


@dataclass(frozen=True, slots=True)
class LeastDelay:
    """The least difference between arrival and stamp, of this window and of the one before."""

    since_ns: int
    """When this window began, on the receiver's clock."""
    least_ns: int
    """In this window."""
    before_ns: int
    """In the window before."""

    def behind_ns(self, delay_ns: int) -> int:
        """How much longer than the least one a message took, in nanoseconds."""
        return max(0, delay_ns - min(self.least_ns, self.before_ns))


def least_after(known: LeastDelay | None, delay_ns: int, now_ns: int) -> LeastDelay:
    """The least delay after one more message.

    Args:
        known: before it; None: it is the first one.
        delay_ns: its arrival, on the receiver's clock, minus its stamp, on the sender's.
        now_ns: its arrival.
    """
    if known is None or now_ns - known.since_ns >= 2 * WINDOW_NS:
        return LeastDelay(now_ns, delay_ns, delay_ns)
    if now_ns - known.since_ns >= WINDOW_NS:
        return LeastDelay(now_ns, delay_ns, known.least_ns)
    if delay_ns >= known.least_ns:
        return known
    return LeastDelay(known.since_ns, delay_ns, known.before_ns)
