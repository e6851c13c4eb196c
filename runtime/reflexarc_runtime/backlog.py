"""How far behind messages are, without comparing two clocks.

Arrival minus stamp is the difference of two clocks plus the time on the way. Its least value so far
stands for a message that came without waiting; what another one took longer, it waited somewhere: a
queue two seconds deep is two seconds old, however regularly it delivers.

Clocks drift, so the least value may rise, by 1 ms a second: a queue of two seconds that stays is
not forgotten before half an hour. Clocks also step. A stamp that goes back, or a message that comes
earlier than any could, tells nothing of the way; then what it was behind stays, and the time since
the message before is added, as if it had been sent right behind that one. So no step makes a
picture younger than it is, but for one: a clock that steps forward by just as much as a queue is
deep looks like the end of that queue.
"""

from dataclasses import dataclass
from typing import NamedTuple

WINDOW_NS = 60_000_000_000
"""The least value counts for one to two windows; then it may have risen."""
DRIFT_NS = 1_000_000
"""A second: more than two clocks drift apart, of which the worst lose 0.5 ms a second."""
STEP_NS = 50_000_000
"""A delay so far below the least one: the sender's clock stepped. By less, it is the least one that
had waited, as where a stream begins."""

MOST_STAMP_NS = 1 << 61
"""Seventy years; a later stamp tells nothing. So all numbers here fit a keyframe's 64 bits."""
MOST_BEHIND_NS = 1 << 60
"""Half as long: nobody drives by it either way."""

_SECOND_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class LeastDelay:
    """The least difference between arrival and stamp, of this window and of the one before."""

    since_ns: int
    """When this window began, on the receiver's clock."""
    least_ns: int
    """In this window."""
    before_ns: int
    """In the window before."""

    @property
    def best_ns(self) -> int:
        """What a message takes that does not wait."""
        return self.least_ns if self.least_ns < self.before_ns else self.before_ns

    def behind_ns(self, delay_ns: int) -> int:
        """How much longer than the least one a message took, in nanoseconds."""
        behind_ns = delay_ns - self.best_ns
        return behind_ns if behind_ns > 0 else 0


def least_after(known: LeastDelay | None, delay_ns: int, now_ns: int) -> LeastDelay:
    """The least delay after one more message.

    Args:
        known: before it; None: it is the first one.
        delay_ns: its arrival, on the receiver's clock, minus its stamp, on the sender's.
        now_ns: its arrival.
    """
    if known is None:
        return LeastDelay(now_ns, delay_ns, delay_ns)
    elapsed_ns = now_ns - known.since_ns
    if elapsed_ns >= WINDOW_NS:
        highest_ns = known.best_ns + elapsed_ns * DRIFT_NS // _SECOND_NS
        return LeastDelay(now_ns, delay_ns, min(known.least_ns, highest_ns))
    if delay_ns >= known.least_ns:
        return known
    return LeastDelay(known.since_ns, delay_ns, known.before_ns)


class Lag(NamedTuple):  # made at every input; a frozen dataclass takes four times as long
    """How far behind its sender's best the last message of a stream came."""

    behind_ns: int = 0
    stamp_ns: int = 0
    """Of that message; 0: it had none, and tells nothing."""
    received_ns: int = 0
    """When it came."""
    least: LeastDelay | None = None
    """None: nothing is known of its sender's clock."""

    def after(
        self, stamp_ns: int, received_ns: int, silence_ns: int, overtaken: bool = False
    ) -> "Lag":
        """After one more message.

        Args:
            stamp_ns: its time on its sender's clock; 0: none.
            received_ns: its arrival, on the receiver's clock.
            silence_ns: whoever was silent for longer may have begun anew, with another clock.
            overtaken: whether its number is below the last one's: then an earlier stamp is no step
                of a clock.
        """
        if stamp_ns > MOST_STAMP_NS:
            stamp_ns = 0
        last_ns, least = self.stamp_ns, self.least
        if least is None or stamp_ns < last_ns:
            return self._begun_anew(stamp_ns, received_ns, silence_ns, overtaken)
        delay_ns = received_ns - stamp_ns
        behind_ns = delay_ns - least.best_ns
        if behind_ns < -STEP_NS:
            return begun(self._grown_ns(received_ns), stamp_ns, received_ns)
        if delay_ns < least.least_ns or received_ns - least.since_ns >= WINDOW_NS:
            return self._followed(least, stamp_ns, received_ns)
        return Lag(behind_ns, stamp_ns, received_ns, least)

    def _followed(self, least: LeastDelay, stamp_ns: int, received_ns: int) -> "Lag":
        delay_ns = received_ns - stamp_ns
        least = least_after(least, delay_ns, received_ns)
        return Lag(least.behind_ns(delay_ns), stamp_ns, received_ns, least)

    def _begun_anew(
        self, stamp_ns: int, received_ns: int, silence_ns: int, overtaken: bool
    ) -> "Lag":
        """After a message whose sender's clock is not known, or went back."""
        if stamp_ns < self.stamp_ns:
            if received_ns - self.received_ns > silence_ns:
                return begun(0, stamp_ns, received_ns)
            if not overtaken:
                return begun(self._grown_ns(received_ns), stamp_ns, received_ns)
        if self.least is None or not stamp_ns:
            return begun(self.behind_ns, stamp_ns, received_ns)
        return self._followed(self.least, stamp_ns, received_ns)

    def _grown_ns(self, received_ns: int) -> int:
        """How far behind a message came at most that was sent right behind the last one."""
        return self.behind_ns + max(0, received_ns - self.received_ns)


NO_LAG = Lag()


def begun(behind_ns: int, stamp_ns: int, received_ns: int) -> Lag:
    """A stream of whose clock nothing is known but how far behind its last message came."""
    behind_ns = min(behind_ns, MOST_BEHIND_NS)
    if not stamp_ns:
        return Lag(behind_ns, 0, received_ns)
    best_ns = received_ns - stamp_ns - behind_ns
    return Lag(behind_ns, stamp_ns, received_ns, LeastDelay(received_ns, best_ns, best_ns))


BACKLOG = "a backlog"
"""How the words of `backlog_in_words` end."""


def backlog_in_words(behind_ns: int) -> str:
    """Why a message that has just come is old all the same."""
    return f"{behind_ns * 1e-9:.1f} s behind its sender's best: {BACKLOG}"
