"""Did the body stop in time? Judged from what it noted, on its own clock.

The rule. Every message that the body put onto the bus is worth the moment at which what it shows
was seen; one that is malformed, not of this body, or stamped with another time is worth nothing.
The *last good input* at a time t is the newest such moment among all that was put until t. The
body may not drive while the last good input is older than

    max_input_age + 2 ticks of the runtime = 100 ms + 40 ms

An outage is a stretch in which it is. Its time to safe runs from the last good input to the first
look at the watchdog that found no drive command to obey: a body that oversleeps goes on doing what
it did, so its oversleeping counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

MS = 1_000_000
BOUND_NS = 140 * MS

Poll = tuple[int, int, bool]
"""(time, lateness of the wake-up, whether a drive command was obeyed), ns."""

Worth = tuple[int, int | None]
"""(when it became known, the moment that it is worth), ns; None: nothing."""


@dataclass(frozen=True)
class Outage:
    """A stretch without a good input."""

    last_good_ns: int
    decided_ns: int | None
    """The last look at which it drove, after the last good input; None: it did not drive."""
    stopped_ns: int | None
    """The first look at which it no longer drove."""
    oversleep_ns: int
    """How late that look was."""
    cause: str
    """Verdict of the command that stopped it, or `watchdog`."""
    told_ns: int | None = None
    """When it heard the runtime's safe command, be it already stopped; None: not in this outage."""

    @property
    def to_safe_ns(self) -> int | None:
        """From the last good input to the stop; None where it did not drive at all."""
        return None if self.stopped_ns is None else self.stopped_ns - self.last_good_ns

    @property
    def to_told_ns(self) -> int | None:
        """From the last good input to the runtime's safe command: the guard behind the watchdog."""
        return None if self.told_ns is None else self.told_ns - self.last_good_ns

    @property
    def is_late(self) -> bool:
        """Over the bound."""
        return self.to_safe_ns is not None and self.to_safe_ns > BOUND_NS

    @property
    def is_the_machine_s(self) -> bool:
        """Late, but only because the body's process was not woken in time: the last look at which
        it chose to drive was within the bound, and the next one was late by all of the excess.
        """
        if not self.is_late or self.decided_ns is None or self.to_safe_ns is None:
            return False
        in_time = self.decided_ns - self.last_good_ns <= BOUND_NS
        return in_time and self.to_safe_ns - self.oversleep_ns <= BOUND_NS


def outages(
    polls: Sequence[Poll], worths: Sequence[Worth], heard: Sequence[tuple[int, str]] = ()
) -> list[Outage]:
    """Every outage, from the body's looks, the truth about what it sent, and what it heard."""
    good_at = _good_at(polls, worths)
    found, index = [], 0
    while index < len(polls):
        if not _is_out(polls[index], good_at[index]):
            index += 1
            continue
        end = index
        while end < len(polls) and _is_out(polls[end], good_at[end]):
            end += 1
        last_good_ns = good_at[index]
        assert last_good_ns is not None
        found.append(_outage(polls, end, last_good_ns, heard))
        index = end
    return found


def driving(polls: Sequence[Poll], begin_ns: int, end_ns: int) -> bool:
    """Whether it drove at any time between."""
    return any(drove for time_ns, _, drove in polls if begin_ns <= time_ns < end_ns)


def _good_at(polls: Sequence[Poll], worths: Sequence[Worth]) -> list[int | None]:
    """The last good input at every look."""
    ordered, position = sorted(worths, key=lambda worth: worth[0]), 0
    newest: int | None = None
    found = []
    for time_ns, _, _ in polls:
        while position < len(ordered) and ordered[position][0] <= time_ns:
            seen_ns = ordered[position][1]
            if seen_ns is not None:
                newest = seen_ns if newest is None else max(newest, seen_ns)
            position += 1
        found.append(newest)
    return found


def _is_out(poll: Poll, good_ns: int | None) -> bool:
    return good_ns is not None and poll[0] - good_ns > BOUND_NS


def _outage(
    polls: Sequence[Poll], end: int, last_good_ns: int, heard: Sequence[tuple[int, str]]
) -> Outage:
    looks = [n for n in range(end) if polls[n][0] >= last_good_ns]
    drove = [n for n in looks if polls[n][2]]
    if not drove:
        return Outage(last_good_ns, None, None, 0, "")
    decided_ns = polls[drove[-1]][0]
    if drove[-1] + 1 >= len(polls):  # it drove to the very end: no stop was seen
        return Outage(last_good_ns, decided_ns, decided_ns, 0, "none")
    stopped_ns, oversleep_ns, _ = polls[drove[-1] + 1]
    cause = _cause(heard, stopped_ns)
    told_ns = _told_ns(heard, last_good_ns, polls[end - 1][0])
    return Outage(last_good_ns, decided_ns, stopped_ns, oversleep_ns, cause, told_ns)


def _cause(heard: Sequence[tuple[int, str]], stopped_ns: int) -> str:
    verdicts = [verdict for time_ns, verdict in heard if time_ns <= stopped_ns]
    return "watchdog" if not verdicts or verdicts[-1] == "OK" else verdicts[-1]


def _told_ns(heard: Sequence[tuple[int, str]], begin_ns: int, end_ns: int) -> int | None:
    times_ns = (time_ns for time_ns, name in heard if name != "OK" and begin_ns < time_ns <= end_ns)
    return next(times_ns, None)
